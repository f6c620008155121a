// The flow of a case or of loose files, by the ranks of one run or by those that the stage starts.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "analysis/flow.hpp"
#include "core/communicator.hpp"
#include "core/files.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "io/image.hpp"
#include "lbm/checkpoint.hpp"
#include "pipeline/run_ranks.hpp"
#include "stages/case_space.hpp"
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

results::Lbm run_lbm(const Case& c, const Path& folder) {
    return c.settings.parallel.ranks > 1 ? lbm_on_ranks(c, folder) : lbm_of_case(c, folder);
}

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

}  // namespace porepack::stages
