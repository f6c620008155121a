// Commands that compute permeabilities: lbm, foam, forchheimer.
#include "analysis/flow.hpp"
#include "analysis/foam.hpp"
#include "analysis/inertia.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/json.hpp"
#include "record/resolved_config.hpp"
#include "stages/work.hpp"

namespace porepack::apps {
namespace {

void run_lbm_command(const Common& common) {
    if (is_case(common.input)) return run_in_case(common, "lbm", "lbm");
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto section = config_of<SectionConfig>(common.flags);
    const auto config = config_of<LbmConfig>(common.flags);
    run_on_input(common, {.stage = "lbm",
                          .geometry = geometry,
                          .section = section,
                          .configuration = {{"geometry", resolved_config(geometry)},
                                            {"section", resolved_config(section)},
                                            {"lbm", resolved_config(config)}},
                          .work =
                              [&](const PoreSpace& space, const Path& folder) {
                                  return run_lbm(space, geometry, config, folder,
                                                 space.image() ? Path() : target_folder(common) / "lbm.checkpoint");
                              },
                          .expect = [&](const PoreSpace& space) { return expect_flow(space, geometry, config); }});
}

void run_foam_command(const Common& common) {
    if (is_case(common.input)) return run_in_case(common, "foam", "openfoam");
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto section = config_of<SectionConfig>(common.flags);
    const auto config = config_of<FoamConfig>(common.flags);
    run_on_input(common, {.stage = "foam",
                          .geometry = geometry,
                          .section = section,
                          .configuration = {{"geometry", resolved_config(geometry)},
                                            {"section", resolved_config(section)},
                                            {"openfoam", resolved_config(config)}},
                          .work =
                              [&](const PoreSpace& space, const Path& folder) {
                                  make_folder(folder / "foam");
                                  results::Foam result = compute_foam_flow(space, geometry, config, folder / "foam");
                                  result.repeat_by_hand = "cd foam/" + result.repeat_by_hand.substr(3);
                                  return result;
                              },
                          .expect = [&](const PoreSpace& space) { return expect_foam(space, config); },
                          .resumes = true});
}

void run_forchheimer_command(const Common& common) {
    if (is_case(common.input)) return run_in_case(common, "forchheimer", "forchheimer");
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto section = config_of<SectionConfig>(common.flags);
    const auto config = config_of<ForchheimerConfig>(common.flags);
    run_on_input(common,
                 {.stage = "forchheimer",
                  .geometry = geometry,
                  .section = section,
                  .configuration = {{"geometry", resolved_config(geometry)},
                                    {"section", resolved_config(section)},
                                    {"forchheimer", resolved_config(config)}},
                  .work = [&](const PoreSpace& space,
                              const Path& folder) { return written(compute_inertial_flows(space, geometry, config, folder), folder); },
                  .expect = [&](const PoreSpace& space) { return expect_inertia(space, config); },
                  .resumes = true});
}

}  // namespace

void add_lbm_command(CommandLine& line) {
    auto lbm = line.add("lbm", "permeability by lattice Boltzmann", "porepack lbm packing.json --voxel-size 2e-4 --direction z",
                        [&line] { run_lbm_command(line.common); });
    line.add_input(lbm, "a case, packing.json[.gz], an STL file or pore.vti");
    line.add_keys(lbm, "geometry", {"surface_deviation_m", "contact_gap_m", "slice_spacing_m", "slice_pixel_m"});
    line.add_keys(lbm, "section");
    line.add_keys(lbm, "lbm");
}

void add_foam_command(CommandLine& line) {
    auto foam = line.add("foam", "permeability by OpenFOAM", "porepack foam packing.json --cell-size 5e-4",
                         [&line] { run_foam_command(line.common); });
    line.add_input(foam, "a case, packing.json[.gz] or an STL file");
    line.add_keys(foam, "geometry", {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
    line.add_keys(foam, "section");
    line.add_keys(foam, "openfoam", {"enabled"});
    line.add_alias(foam, "--levels", "meshes");
}

void add_forchheimer_command(CommandLine& line) {
    auto inertia = line.add("forchheimer", "flows with inertia by both solvers: permeability against the Reynolds number",
                            "porepack forchheimer packing.json --reynolds 2,5,10,20,40", [&line] { run_forchheimer_command(line.common); });
    line.add_input(inertia, "a case, packing.json[.gz] or an STL file");
    line.add_keys(inertia, "geometry", {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
    line.add_keys(inertia, "section");
    line.add_keys(inertia, "forchheimer", {"enabled"});
}

}  // namespace porepack::apps
