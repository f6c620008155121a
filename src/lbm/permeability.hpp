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
    double bytes_per_node = 0.0;
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

/// Makes the phase image at about the voxel size given.
using Voxeliser = std::function<PhaseImage(double voxel_size_m)>;

/// Solves at `voxel_size_m`, and before that on the coarser grid if config.grids is 2. `section` lies in the image.
/// Throws NumericalError when the pore space does not percolate or the gate is not passed: no k then.
[[nodiscard]] LbmResult lbm_permeability(const Voxeliser& voxeliser, double voxel_size_m, const Container& container,
                                         const Section& section, const LbmConfig& config, bool with_flow);

}  // namespace porepack
