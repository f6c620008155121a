// Commands that compute permeabilities: lbm, foam, forchheimer.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "analysis/flow.hpp"
#include "analysis/foam.hpp"
#include "analysis/inertia.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/communicator.hpp"
#include "core/context.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "lbm/domain.hpp"
#include "lbm/layered_flow.hpp"
#include "lbm/slabs.hpp"
#include "parallel/mpi_ranks.hpp"
#include "record/resolved_config.hpp"
#include "stages/work.hpp"

namespace porepack::apps {
namespace {

// This process becomes one of several, or is one.
void require_ranks(const CommandLine& line) {
    const Common& common = line.common;
    const int started = ranks().parts();
    const char* const tasks = std::getenv("SLURM_STEP_NUM_TASKS");
    if (started == 1 && tasks != nullptr && std::atoi(tasks) > 1)
        throw UserError(fmt::format("srun has started {} tasks, which do not know of each other", tasks), {.fix = "srun --mpi=pmix"});
    if (common.ranks == 0 || common.ranks == started || common.dry_run) return;
    if (started > 1)
        throw UserError(fmt::format("--ranks {}, and the launcher has started {}", common.ranks, started), {.fix = "leave out --ranks"});
    parallel::start_ranks(static_cast<int>(common.ranks), line.arguments);
}

// Mean memory of a slab; UserError for more ranks than the coarsest grid has slabs.
Expectation of_one_rank(Expectation expected, long ranks, long most) {
    if (ranks < 2) return expected;
    if (ranks > most) throw lbm::too_many_parts(ranks, most);
    expected.memory_bytes = lbm::program_bytes + (expected.memory_bytes - lbm::program_bytes) / static_cast<double>(ranks);
    expected.text += fmt::format("; {} ranks, memory of each", ranks);
    return expected;
}

void run_lbm_command(const CommandLine& line) {
    const Common& common = line.common;
    if (is_case(common.input)) {
        if (common.ranks > 1 || ranks().parts() > 1)
            throw UserError("a case runs in one process",
                            {.where = "--ranks", .fix = "give its packing.json: porepack lbm packing.json --ranks 2"});
        return run_in_case(common, "lbm", "lbm");
    }
    require_ranks(line);
    const Context silent{.log = [](auto, auto) {}, .progress = [](auto, auto, auto, auto) {}};
    std::optional<ContextScope> scope;
    if (ranks().part() > 0) scope.emplace(silent);
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
                          .expect =
                              [&](const PoreSpace& space) {
                                  return of_one_rank(expect_flow(space, geometry, config), std::max<long>(common.ranks, ranks().parts()),
                                                     lbm::most_parts(space, space.voxel_size_m(geometry.voxel_size_m), config));
                              },
                          .of_other_ranks =
                              [&](const PoreSpace& space) {
                                  const ComputedFlow flow = compute_flow(space, geometry, config);
                                  if (config.fields != FieldFiles::none) lbm::answer_first_part(flow.field);
                              }});
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
                        [&line] { run_lbm_command(line); });
    lbm.add_option("--ranks", line.common.ranks,
                   "processes of MPI, each with a slab of the voxels (docs/cluster.md); default: those that mpirun has started, or one")
        .type_name("1 to 10000")
        .range(1L, 10000L);
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
