// Command `pores`.
#include "analysis/pores.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "record/resolved_config.hpp"

namespace porepack::apps {

void add_pores_command(CommandLine& line) {
    const Common& common = line.common;
    auto pores =
        line.add("pores", "the pore space: chords, pore sizes, critical diameter, correlation",
                 "porepack pores packing.json --voxel-size 2e-4 --output pores", [&common] {
                     if (is_case(common.input))
                         throw UserError("the pores of a file are described, not of a case",
                                         {.where = common.input, .fix = "porepack pores CASE/results/pack/packing.json"});
                     const auto geometry = config_of<GeometryConfig>(common.flags);
                     run_on_input(common, {.stage = "pores",
                                           .geometry = geometry,
                                           .configuration = {{"geometry", resolved_config(geometry)}},
                                           .work = [&](const PoreSpace& space,
                                                       const Path& folder) { return written(describe_pores(space, geometry), folder); },
                                           .expect = [&](const PoreSpace& space) { return expect_pores(space, geometry); }});
                 });
    line.add_input(pores, "packing.json[.gz], an STL file or an image");
    line.add_keys(pores, "geometry", {"slice_spacing_m", "slice_pixel_m", "reservoir_m", "surface_deviation_m", "contact_gap_m"});
}

}  // namespace porepack::apps
