// What a run on one grid gives, in SI units.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/members.hpp"
#include "lbm/stokes_run.hpp"
#include "pore_space/stretch.hpp"

namespace porepack::lbm {

struct LbmGridResult {
    double voxel_size_m = 0.0;
    std::array<int, 3> cells = {0, 0, 0};
    std::size_t nodes = 0;
    std::int64_t isolated_cells = 0;
    std::size_t wall_links = 0;
    double narrow_share = 0.0;  ///< fraction of the wall links that lie in a gap of one node
    double bytes_per_node = 0.0;
    double set_up_seconds = 0.0;
    double relaxation_time = 0.0;
    double permeability_m2 = 0.0;                     ///< by flow rate
    double permeability_volume_m2 = 0.0;              ///< by volume average; the difference checks the mass balance
    std::optional<pore_space::Stretch> stretch = {};  ///< of a periodic box, to whole numbers of voxels
    std::optional<double> bed_permeability_m2 = {};   ///< of the whole bed, free ends included, if the flow goes through all of it
    bool by_pressure = false;                         ///< end planes of constant pressure; else periodic along the flow
    StokesRun run = {};                               ///< of a grid that a checkpoint had finished, without layers and history
    /// Of a layer of voxels, in the box that was given.
    [[nodiscard]] double layer_height_m() const { return voxel_size_m / (stretch ? (*stretch)[2] : 1.0); }
};
template <core::MembersOf<LbmGridResult> Self, typename Visit>
void visit_members(Self& grid, const Visit& visit) {
    visit("voxel_size_m", grid.voxel_size_m);
    visit("cells", grid.cells);
    visit("stretch", grid.stretch);
    visit("fluid_nodes", grid.nodes);
    visit("isolated_cells", grid.isolated_cells);
    visit("permeability_m2", grid.permeability_m2);
    visit("permeability_by_volume_average_m2", grid.permeability_volume_m2);
    visit("permeability_bed_m2", grid.bed_permeability_m2);
    visit("permeability_lu", grid.run.permeability_lu);
    visit("superficial_velocity_lu", grid.run.superficial_velocity_lu);
    visit("hydraulic_tortuosity", grid.run.hydraulic_tortuosity);
    visit("iteration_error", grid.run.iteration_error);
    visit("converged", grid.run.converged);
    visit("flow_imbalance", grid.run.flow_imbalance);
    visit("mass_leak_per_step", grid.run.mass_leak);
    visit("relaxation_time", grid.relaxation_time);
    visit("steps", grid.run.steps);
    visit("seconds", grid.run.seconds);
    visit("updates_per_second", grid.run.updates_per_second);
    visit("set_up_seconds", grid.set_up_seconds);
    visit("bytes_per_node", grid.bytes_per_node);
    visit("wall_links", grid.wall_links);
    visit("narrow_share", grid.narrow_share);
    visit("driven_by_pressure", grid.by_pressure);
}

/// A part of the section along z.
struct SubsectionResult {
    double z0_m, z1_m, permeability_m2;
};
template <core::MembersOf<SubsectionResult> Self, typename Visit>
void visit_members(Self& part, const Visit& visit) {
    visit("z0_m", part.z0_m);
    visit("z1_m", part.z1_m);
    visit("permeability_m2", part.permeability_m2);
}

}  // namespace porepack::lbm
