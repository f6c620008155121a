// One stage on loose files, outside any case.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/members.hpp"
#include "core/members_json.hpp"

namespace porepack::pipeline {

struct LooseRun {
    std::string stage;
    core::Path target;                           ///< folder for the results
    core::Json configuration = {};               ///< for the manifest
    std::vector<core::Path> inputs = {};         ///< for the manifest; a result never overwrites one of them
    core::JsonFunction<const core::Path&> work;  ///< writes into the folder, returns the result
    bool resumes = false;                        ///< `work` finds its folder again after it was interrupted
    std::function<core::Json()> versions = [] { return core::Json::object(); };
};

/// Runs `work` in a temporary folder inside the target, writes <stage>.result.json and <stage>.manifest.json beside its files and moves all
/// of them into the target, replacing what porepack has written there before. Throws UserError when something of the user has the same
/// name; what was computed then stays in the folder <stage>_1 of the target.
core::Json run_loose(const LooseRun& run);

}  // namespace porepack::pipeline
