// A manifest accompanies each result: inputs, settings, versions, machine and cost.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/files.hpp"
#include "core/json.hpp"

namespace porepack::record {

struct Manifest {
    std::string stage;
    long result_version = 1;                          ///< of the stage: raised in the code when its numbers can change
    core::Json configuration = {};                    ///< resolved
    std::map<std::string, std::string> inputs = {};   ///< name -> sha256
    std::map<std::string, std::string> outputs = {};  ///< name -> sha256
    core::Json versions = {};
    long seed = 0;
    long processes = 1;
    double wall_time_s = 0.0;
    double peak_memory_bytes = 0.0;
};

/// A configuration without zero, false and empty values, which stand for keys that are not given: results stay current when a later version
/// adds such a key.
[[nodiscard]] core::Json given_values(const core::Json& configuration);
/// Digest of all that determines the result: stage, result version, given values of the configuration, inputs.
[[nodiscard]] std::string key_of(const Manifest& manifest);
[[nodiscard]] core::Json to_json(const Manifest& manifest);

enum class StageState { missing, done, stale, failed, running };
constexpr std::array<core::Choice<StageState>, 5> choices_of(StageState) {
    return {{{StageState::missing, "missing"},
             {StageState::done, "done"},
             {StageState::stale, "stale"},
             {StageState::failed, "failed"},
             {StageState::running, "interrupted or running"}}};
}

/// Compares the manifest in `folder` with the one expected now; `why` says what differs.
[[nodiscard]] StageState state_of(const core::Path& folder, const Manifest& expected, std::string* why = nullptr);

}  // namespace porepack::record
