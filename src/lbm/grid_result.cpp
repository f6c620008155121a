#include "lbm/permeability.hpp"

namespace porepack {
namespace {

// visit(name, member) for all that a finished grid keeps.
template <typename Grid, typename Visit>
void visit_members(Grid& grid, const Visit& visit) {
    visit("voxel_size_m", grid.voxel_size_m);
    visit("cells", grid.cells);
    visit("fluid_nodes", grid.nodes);
    visit("isolated_cells", grid.isolated_cells);
    visit("permeability_m2", grid.permeability_m2);
    visit("permeability_by_volume_average_m2", grid.permeability_volume_m2);
    visit("permeability_lu", grid.run.permeability_lu);
    visit("superficial_velocity_lu", grid.run.superficial_velocity_lu);
    visit("hydraulic_tortuosity", grid.run.hydraulic_tortuosity);
    visit("iteration_error", grid.run.iteration_error);
    visit("flow_imbalance", grid.run.flow_imbalance);
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

}  // namespace

Json to_json(const LbmGridResult& grid) {
    Json json;
    visit_members(grid, [&](const char* name, const auto& value) { json[name] = value; });
    return json;
}

LbmGridResult grid_from_json(const Json& json) {
    LbmGridResult grid;
    visit_members(grid, [&](const char* name, auto& value) { json.at(name).get_to(value); });
    grid.run.converged = true;
    return grid;
}

}  // namespace porepack
