// The grains as one closed triangle surface.
#include <string>
#include <vector>

#include "analysis/surfaces.hpp"
#include "inputs/mesh_vessel.hpp"
#include "inputs/pore_space_input.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

Stage make_stl_stage(const Case& c) {
    const bool with_planes = c.settings.stl.pores || c.settings.stl.clip;
    const Path user_file = c.from_surface() ? c.resolve(c.settings.shape.file) : Path();
    Stage stage{.name = "stl",
                .needs = c.from_surface() ? std::vector<std::string>{} : std::vector<std::string>{"pack"},
                .configuration = deciding_keys(c, {"container", "shape", "stl"}, {"surface_deviation_m", "contact_gap_m"}, with_planes),
                .outputs = {"solid.stl"},
                .result_version = results::Stl::version};
    if (c.from_surface()) {
        stage.files = inputs::vessel_files(c.settings.container, c.folder);
        stage.files.push_back(user_file);
    }
    stage.run = [c, user_file, with_planes](const Path& folder) {
        InputOptions options{.container = case_container(c),
                             .unit_m = c.from_surface() ? surface_unit_m(c.settings.shape) : 1.0,
                             .geometry = c.settings.geometry,
                             .whole_bed = !with_planes};
        options.geometry.closing_radius_m = 0.0;  // the surface has no menisci
        return write_surfaces(load_pore_space(c.from_surface() ? user_file : c.stage_folder("pack") / "packing.json", options),
                              c.settings.geometry, c.settings.stl, folder);
    };
    return stage;
}

}  // namespace porepack::stages
