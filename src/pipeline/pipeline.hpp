// Runs a chain of stages. A stage runs in a hidden folder that moves to results/ only when it is complete; a stage that is done
// with the same inputs is not run again.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/expectation.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "pipeline/stage.hpp"
#include "record/manifest.hpp"

namespace porepack::pipeline {

struct Pipeline {
    core::Path results;                                                          ///< one folder per stage is made here
    std::vector<Stage> stages;                                                   ///< each after those that it needs
    std::function<core::Json()> versions = [] { return core::Json::object(); };  ///< of the programs that stages run, for the manifests
    std::string left_out = {};  ///< stages that the settings disable, for the message when one of them is requested
};

[[nodiscard]] core::Path stage_folder(const Pipeline& pipeline, const std::string& stage);

struct StageStatus {
    std::string name;
    record::StageState state = record::StageState::missing;
    std::string why = {};  ///< why it is not done
    double wall_time_s = 0.0;
};
[[nodiscard]] std::vector<StageStatus> status_of(const Pipeline& pipeline);

/// True if `last` and all stages that it needs are done.
[[nodiscard]] bool is_done(const Pipeline& pipeline, const std::string& last);

/// What determines the results up to `last`: of each stage, its result version, its configuration and the digests of the user's files.
[[nodiscard]] core::Json identity_of(const Pipeline& pipeline, const std::string& last = {});

/// Runs the stages not yet done, up to and including `last` (if empty: the last of all), and only those that it needs. Returns its result.
/// A stage that fails stops the chain; its folder stays as results/<stage>.failed. After an optional stage that fails, the others run; its
/// error is thrown at the end, and an earlier result of it, which was out of date, is removed. Throws UserError when another process runs
/// here or there is no such stage, and passes on what the stages throw.
core::Json run_pipeline(const Pipeline& pipeline, const std::string& last = {});

/// What the stages that would run need together: the largest memory, the sums of times and disk space.
[[nodiscard]] core::Expectation expected_of(const Pipeline& pipeline, const std::string& last = {});
/// The stages that would run, with the expected memory, time and disk space of each and of all; times are multiplied by `slowness`.
[[nodiscard]] core::Json plan_pipeline(const Pipeline& pipeline, const std::string& last = {}, double slowness = 1.0);

}  // namespace porepack::pipeline
