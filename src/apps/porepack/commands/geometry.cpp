// Commands that turn grains into a surface, voxels and slices.
#include "analysis/surfaces.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/members_json.hpp"
#include "record/resolved_config.hpp"
#include "stages/work.hpp"

namespace porepack::apps {
namespace {

constexpr const char* inputs = "a case, packing.json[.gz] or an STL file";

void run_stl(const Common& common) {
    if (is_case(common.input)) return run_in_case(common, "stl", "stl");
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto extras = config_of<StlConfig>(common.flags);
    run_on_input(common, {.stage = "stl",
                          .geometry = geometry,
                          .configuration = {{"geometry", resolved_config(geometry)}, {"stl", resolved_config(extras)}},
                          .work = [&](const PoreSpace& space,
                                      const Path& folder) { return analysis::write_surfaces(space, geometry, extras, folder); },
                          .whole_bed = !extras.pores && !extras.clip});
}

results::Slices write_slices_folder(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    make_folder(folder / "slices");
    return write_slice_images(space, geometry, folder / "slices");
}

void run_on_voxels(const Common& common, const char* stage, JsonFunction<const PoreSpace&, const GeometryConfig&, const Path&> write) {
    if (is_case(common.input)) return run_in_case(common, stage, "geometry");
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto section = config_of<SectionConfig>(common.flags);
    run_on_input(common, {.stage = stage,
                          .geometry = geometry,
                          .section = section,
                          .configuration = {{"geometry", resolved_config(geometry)}, {"section", resolved_config(section)}},
                          .work = [&](const PoreSpace& space, const Path& folder) { return write(space, geometry, folder); }});
}

}  // namespace

void add_geometry_commands(CommandLine& line) {
    const Common& common = line.common;
    auto stl =
        line.add("stl", "one closed triangle surface of the grains (CGAL)", "porepack stl packing.json --pores", [&] { run_stl(common); });
    line.add_input(stl, inputs);
    line.add_keys(stl, "geometry", {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
    line.add_keys(stl, "stl");
    auto voxelise = line.add("voxelise", "grains to voxels (pore.vti)", "porepack voxelise packing.json --voxel-size 2e-4",
                             [&] { run_on_voxels(common, "voxelise", write_voxels); });
    auto slices = line.add("slices", "grains to a stack of images", "porepack slices packing.json --slice-spacing 2e-4",
                           [&] { run_on_voxels(common, "slices", write_slices_folder); });
    for (auto command : {voxelise, slices}) {
        line.add_input(command, inputs);
        line.add_keys(command, "geometry");
        command.option("--section").description("z0,z1 of the section [m]; default: the bed minus the trim");
    }
    line.add_keys(voxelise, "section");
    line.add_alias(slices, "--spacing", "slice_spacing_m");
    line.add_alias(slices, "--pixel", "slice_pixel_m");
}

}  // namespace porepack::apps
