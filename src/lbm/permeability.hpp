// Permeability of a pore space by lattice Boltzmann, in SI units, on one grid or two.
#pragma once

#include <functional>
#include <optional>

#include "converters/voxels.hpp"
#include "lbm/config.hpp"
#include "lbm/solver.hpp"

namespace porepack {

struct LbmGridResult {
    double voxel_size_m = 0.0;
    std::array<int, 3> cells = {0, 0, 0};
    std::size_t nodes = 0;
    std::int64_t isolated_cells = 0;
    std::size_t wall_links = 0;
    double narrow_share = 0.0;  ///< of the wall links, those in a gap of one node
    double bytes_per_node = 0.0;
    double set_up_seconds = 0.0;
    double permeability_m2 = 0.0;         ///< by flow rate
    double permeability_volume_m2 = 0.0;  ///< by volume average; the difference checks the mass balance
    bool by_pressure = false;             ///< driven by pressure planes, else by a body force
    StokesRun run = {};
};

struct LbmResult {
    LbmGridResult fine;
    std::optional<LbmGridResult> coarse;
    std::optional<Interval> interval_m2;  ///< only with two grids
    FlowImage flow;                       ///< empty unless asked for
};

/// What is solved. The pore space comes as an image at about the voxel size given; `solid`, if there is one, gives the exact
/// distances of its walls, else walls lie half-way between nodes. `section` lies in the image.
struct LbmScene {
    std::function<PhaseImage(double voxel_size_m)> voxels;
    const Solid* solid = nullptr;
    Container container;
    Section section;
};

[[nodiscard]] Scheme scheme_of(const LbmConfig& config, bool exact_walls, const Drive& drive);

/// Solves at `voxel_size_m`, and before that on the coarser grid if config.grids is 2. Throws NumericalError when the pore space
/// does not percolate or the gate is not passed: no k then.
[[nodiscard]] LbmResult lbm_permeability(const LbmScene& scene, double voxel_size_m, const LbmConfig& config, bool with_flow);

}  // namespace porepack
