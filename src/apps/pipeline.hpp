// The chain of stages of a case. A stage runs in a hidden folder and takes its place under results/ only when it is whole.
#pragma once

#include <functional>
#include <vector>

#include "apps/case.hpp"
#include "core/manifest.hpp"

namespace porepack {

struct Stage {
    std::string name;
    std::vector<std::string> needs;    ///< stages whose results it reads
    Json configuration;                ///< all settings that decide its result
    std::vector<Path> files;           ///< a user's files that it reads
    std::vector<std::string> outputs;  ///< files whose change makes it stale; result.json is always one
    std::function<Json(const Path& folder)> run;
    std::function<std::string()> expect;  ///< for --dry-run: what will run, memory and time
    bool goes_on = false;                 ///< run() goes on from what a stopped run left in its folder; else that is removed
    long result_version = 1;  ///< raised when the stage's numbers can change: old results are stale then
};

/// All stages that this case asks for, in order.
[[nodiscard]] std::vector<Stage> stages_of(const Case& the_case);

struct StageStatus {
    std::string name;
    StageState state;
    std::string why;
    double wall_time_s = 0.0;
};
[[nodiscard]] std::vector<StageStatus> status_of(const Case& the_case);

/// Runs what is not done, up to and including stage `last` (the report when empty), only what `last` needs. Returns the result of
/// the last one. A stage that fails stops the chain; its folder stays as results/<stage>.failed.
Json run_case(const Case& the_case, const std::string& last = {});

/// The dry run's text: resolved configuration, what would run, memory and time.
[[nodiscard]] Json plan_case(const Case& the_case, const std::string& last = {});

/// Versions of the engines, for manifests and --version; empty text for one that is missing.
[[nodiscard]] Json engine_versions();

/// Runs `work` in a temporary folder inside `target`, writes <stage>.result.json and <stage>.manifest.json beside the files
/// and moves all of them into `target`, replacing what has the same name. For calls on loose files. With `goes_on` the temporary
/// folder of a run that was stopped is kept, and `work` finds it again.
Json run_loose(const std::string& stage, const Path& target, const Json& configuration, const std::vector<Path>& inputs,
               const std::function<Json(const Path&)>& work, bool goes_on = false);

}  // namespace porepack
