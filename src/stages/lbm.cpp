// Permeability by lattice Boltzmann.
#include <filesystem>

#include "analysis/flow.hpp"
#include "core/communicator.hpp"
#include "core/files.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "io/image.hpp"
#include "lbm/checkpoint.hpp"
#include "lbm/permeability.hpp"
#include "pipeline/run_ranks.hpp"
#include "pore_space/closing.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"
#include "stages/work.hpp"

namespace porepack::stages {

results::Lbm run_lbm(PoreSpace space, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder, const Path& checkpoint) {
    ComputedFlow flow = compute_flow(std::move(space), geometry, config, checkpoint);
    const bool first = ranks().part() == 0;
    results::Lbm result = first ? written(std::move(flow.outcome), folder) : std::move(flow.outcome.result);
    if (config.fields != FieldFiles::none) io::write_flow_image(folder / "flow.vti", flow.field, ranks());
    return result;
}

namespace {

constexpr const char* file_of_ranks = "ranks.json";

// By all ranks.
results::Lbm lbm_of_case(const Case& c, const Path& folder) {
    const auto run = [&] {
        return run_lbm(case_pore_space(c), c.settings.geometry, c.settings.lbm, folder, c.results() / "lbm.checkpoint");
    };
    try {
        return run();
    } catch (const CheckpointOfAnotherRun& other) {  // of settings that the case no longer has
        if (ranks().part() == 0) {
            log_warning(fmt::format("{} is of other settings and is removed", other.file.string()));
            std::filesystem::remove(other.file);
        }
        (void)ranks().gather({});
        return run();
    }
}

results::Lbm lbm_on_ranks(const Case& c, const Path& folder) {
    run_ranks(c.settings.parallel.ranks, rank_arguments("lbm", c, folder), folder);
    const auto result = from_json_members<results::Lbm>(read_json(folder / file_of_ranks));
    std::filesystem::remove(folder / file_of_ranks);
    return result;
}

}  // namespace

std::vector<std::string> rank_arguments(const std::string& stage, const Case& c, const Path& folder) {
    const auto whole = [](const Path& path) { return std::filesystem::absolute(path).string(); };
    std::vector<std::string> arguments = {stage, whole(c.folder), "--into", whole(folder), "--output", whole(c.results())};
    const std::vector<std::string> set = set_arguments(c);
    arguments.insert(arguments.end(), set.begin(), set.end());
    return arguments;
}

void run_lbm_rank(const Case& c, const Path& folder) {
    const results::Lbm result = lbm_of_case(c, folder);
    if (ranks().part() == 0) write_json(folder / file_of_ranks, json_of(result));
}

Stage make_lbm_stage(const Case& c) {
    const long ranks = c.settings.parallel.ranks;
    Stage stage{.name = "lbm",
                .needs = {solid_stage(c)},
                .configuration = deciding_keys(c, {"container", "section", "lbm"}, {"voxel_size_m", "reservoir_m"}, true),
                .outputs = {"history.csv"},
                .result_version = results::Lbm::version,
                .processes = ranks};
    if (c.settings.lbm.direction == Axis::z) stage.outputs.emplace_back("gradient.csv");
    if (c.settings.lbm.fields != FieldFiles::none) stage.outputs.emplace_back("flow.vti");
    stage.run = [c, ranks](const Path& folder) { return ranks > 1 ? lbm_on_ranks(c, folder) : lbm_of_case(c, folder); };
    stage.expect = [c, ranks] {
        const PoreSpace space = expected_pore_space(c);
        const double asked = c.settings.geometry.voxel_size_m,
                     voxel = asked > 0.0 || space.own_grid() ? space.voxel_size_m(asked) : space.grain_size_m / 10.0;
        Expectation flow = on_ranks(expect_flow(space, c.settings.lbm, voxel, expected_porosity(c)), ranks, space, voxel, c.settings.lbm);
        if (const double radius = c.settings.geometry.closing_radius_m; radius > 0.0) {  // each rank makes all menisci
            const double menisci = closing_memory_bytes(space, radius);
            flow.memory_bytes = std::max(flow.memory_bytes, static_cast<double>(std::max(1L, ranks)) * menisci);
            if (ranks > 1) flow.text += fmt::format("; the menisci take {} in each", human_bytes(menisci));
        }
        return flow;
    };
    return stage;
}

}  // namespace porepack::stages
