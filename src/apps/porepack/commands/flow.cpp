// Commands that compute permeabilities: lbm, foam, forchheimer.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "analysis/flow.hpp"
#include "analysis/foam.hpp"
#include "analysis/inertia.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/communicator.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "lbm/permeability.hpp"
#include "pipeline/run_ranks.hpp"
#include "record/resolved_config.hpp"
#include "stages/work.hpp"

namespace porepack::apps {
namespace {

// The ranks that a launcher has started, and those that are asked for, fit together.
void require_ranks(const Common& common) {
    const int started = ranks().parts();
    const char* const tasks = std::getenv("SLURM_STEP_NUM_TASKS");
    if (started == 1 && tasks != nullptr && std::atoi(tasks) > 1)
        throw UserError(fmt::format("srun has started {} tasks, which do not know of each other", tasks), {.fix = "srun --mpi=pmix"});
    if (started > 1 && common.ranks != 0 && common.ranks != started)
        throw UserError(fmt::format("--ranks {}, and the launcher has started {}", common.ranks, started), {.fix = "leave out --ranks"});
}

void require_one_start(const std::string& what) {
    if (ranks().parts() > 1)
        throw UserError(what + " starts its ranks itself, for its flows only",
                        {.where = "mpirun or srun", .fix = "start porepack once, with --ranks or, in a case, [parallel] ranks"});
}

void run_lbm_command(const CommandLine& line) {
    const Common& common = line.common;
    require_ranks(common);
    if (is_case(common.input)) {
        if (!common.into.empty()) return stages::run_lbm_rank(open_case(common, "lbm", common.flags), common.into);
        require_one_start("a case");
        return run_in_case(common, "lbm", "lbm");
    }
    if (common.ranks > 1 && ranks().parts() == 1 && !common.dry_run) {
        const Path target = target_folder(common);
        const bool is_new = !std::filesystem::exists(target);
        make_folder(target);
        try {
            return pipeline::run_ranks(common.ranks, line.arguments, target);
        } catch (...) {  // what is refused leaves nothing behind
            std::error_code ignored;
            if (is_new && std::filesystem::is_empty(target, ignored)) std::filesystem::remove(target, ignored);
            throw;
        }
    }
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
                              [&](PoreSpace space, const Path& folder) {
                                  const Path checkpoint = space.own_grid() ? Path() : target_folder(common) / "lbm.checkpoint";
                                  return run_lbm(std::move(space), geometry, config, folder, checkpoint);
                              },
                          .expect =
                              [&](const PoreSpace& space) {
                                  return on_ranks(expect_flow(space, geometry, config), std::max<long>(common.ranks, ranks().parts()),
                                                  space, space.voxel_size_m(geometry.voxel_size_m), config);
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

void run_forchheimer_command(const CommandLine& line) {
    const Common& common = line.common;
    if (common.into.empty()) require_one_start("forchheimer");
    if (is_case(common.input)) {
        Common wanted = common;
        wanted.flags["enabled"] = "true";  // the command asks for the stage, whatever the case says
        if (common.into.empty()) return run_in_case(wanted, "forchheimer", "forchheimer");
        return stages::run_forchheimer_rank(open_case(wanted, "forchheimer", wanted.flags), common.into);
    }
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto section = config_of<SectionConfig>(common.flags);
    const auto config = config_of<ForchheimerConfig>(common.flags);
    const auto work = [&](const PoreSpace& space, const Path& folder) {
        if (common.ranks > 1) {
            std::vector<std::string> arguments = line.arguments;
            arguments.insert(arguments.end(), {"--into", std::filesystem::absolute(folder).string()});
            pipeline::run_ranks(common.ranks, arguments, folder);
        }
        return written(compute_inertial_flows(space, geometry, config, folder), folder);
    };
    const LooseCommand command{.stage = "forchheimer",
                               .geometry = geometry,
                               .section = section,
                               .configuration = {{"geometry", resolved_config(geometry)},
                                                 {"section", resolved_config(section)},
                                                 {"forchheimer", resolved_config(config)}},
                               .work = work,
                               .expect =
                                   [&](const PoreSpace& space) {
                                       return on_ranks(expect_inertia(space, config), common.ranks, space,
                                                       space.voxel_size_m(config.voxel_size_m), {.device = config.device});
                                   },
                               .resumes = true};
    if (!common.into.empty()) return solve_lattice_grids(load_input(common, command), config, common.into);
    run_on_input(common, command);
}

}  // namespace

void add_lbm_command(CommandLine& line) {
    auto lbm = line.add("lbm", "permeability by lattice Boltzmann", "porepack lbm packing.json --voxel-size 2e-4 --direction z",
                        [&line] { run_lbm_command(line); });
    line.add_ranks(lbm,
                   "processes of MPI, each with a slab of the voxels (docs/cluster.md); default: those that mpirun has started, [parallel] "
                   "ranks of a case, or one");
    lbm.add_option("--into", line.common.into, "the ranks of a case's flow: the folder of its stage").hidden();
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
                            "porepack forchheimer packing.json --reynolds 2,5,10,20,40", [&line] { run_forchheimer_command(line); });
    line.add_input(inertia, "a case, packing.json[.gz] or an STL file");
    line.add_ranks(inertia,
                   "processes of MPI for the flows by lattice Boltzmann (docs/cluster.md); default: [parallel] ranks of a case, or one");
    inertia.add_option("--into", line.common.into, "the ranks: the folder of the stage").hidden();
    line.add_keys(inertia, "geometry", {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
    line.add_keys(inertia, "section");
    line.add_keys(inertia, "forchheimer", {"enabled"});
}

}  // namespace porepack::apps
