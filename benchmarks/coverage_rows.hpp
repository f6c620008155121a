// The table of runs on random packings, and their references.
#pragma once

#include <array>
#include <vector>

#include "core/files.hpp"
#include "core/json.hpp"
#include "lbm/permeability.hpp"

namespace porepack::benchmarks {

/// Of the finest grid of a reference: of the first 40 beds, and of those that were added later.
inline constexpr double reference_nodes = 4e6, reference_nodes_of_later_beds = 2.5e6;

/// One run with a tolerance, and the reference of its bed.
struct CoverageRow {
    int bed = 0, position = 0;
    double tolerance = 0.0, porosity = 0.0;
    std::array<double, 3> reference_nodes{}, references_m2{};
    double reference_other_half_width = 0.0;  ///< iteration, mass balance, rounding; relative
    std::array<double, 3> nodes{}, values_m2{};
    double other_half_width = 0.0;  ///< iteration, mass balance, rounding; relative
    double seconds = 0.0;
};

[[nodiscard]] std::vector<CoverageRow> read_rows(const core::Path& file);
void write_rows(const core::Path& file, const std::vector<CoverageRow>& rows);

/// The Richardson value of order 2 of the last two grids; its half width is its change from that of the first two, and the iteration error.
/// (Not lbm::extrapolate(), which is what is judged.)
struct Reference {
    double value_m2 = 0.0, half_width = 0.0;  ///< half width relative
};
[[nodiscard]] Reference reference_of(const CoverageRow& row);

/// Three grids, the finest with about `nodes` nodes.
[[nodiscard]] lbm::LbmResult reference_run(const pore_space::PoreSpace& space, double nodes);

/// Of all contributions but the grid, relative.
[[nodiscard]] double other_half_width(const lbm::LbmResult& result);

/// The last three grids of a result, which are enough to repeat the extrapolation with other constants: nodes per grain diameter, k.
void last_grids(const lbm::LbmResult& result, const pore_space::PoreSpace& space, std::array<double, 3>& nodes,
                std::array<double, 3>& values_m2);

/// A run whose extrapolation can be repeated; values relative to the true k.
struct LastGrids {
    std::array<double, 3> nodes{}, values{};
    double grains = 1.0, other_half_width = 0.0;
};
/// Number of runs whose interval holds the true k, median error and median half width, with the constants in use and with some others.
[[nodiscard]] core::Json with_other_constants(const std::vector<LastGrids>& runs);

}  // namespace porepack::benchmarks
