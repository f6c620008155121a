// Runs a chain of stages. A stage runs in a hidden folder and takes its place under results/ only when it is whole; a stage that is done
// with the same inputs is not run again.
#pragma once

#include <string>
#include <vector>

#include "pipeline/manifest.hpp"
#include "pipeline/stage.hpp"

namespace porepack::pipeline {

struct Pipeline {
    core::Path results;                                                   ///< one folder per stage is made here
    std::vector<Stage> stages;                                      ///< each behind those that it needs
    std::function<core::Json()> versions = [] { return core::Json::object(); };  ///< of the programs that stages run, for the manifests
    std::string left_out = {};  ///< stages that the settings leave out, for the message when one of them is asked for
};

[[nodiscard]] core::Path stage_folder(const Pipeline& pipeline, const std::string& stage);

struct StageStatus {
    std::string name;
    StageState state = StageState::missing;
    std::string why = {};  ///< why it is not done
    double wall_time_s = 0.0;
};
[[nodiscard]] std::vector<StageStatus> status_of(const Pipeline& pipeline);

/// Runs what is not done, up to and including the stage `last` (the last of all when empty), and only what it needs. Returns its result.
/// A stage that fails stops the chain; its folder stays as results/<stage>.failed. Throws UserError when another process runs here or
/// there is no such stage, and what the stages throw.
core::Json run_pipeline(const Pipeline& pipeline, const std::string& last = {});

/// What would run, with the expected memory and time of each stage.
[[nodiscard]] core::Json plan_pipeline(const Pipeline& pipeline, const std::string& last = {});

}  // namespace porepack::pipeline
