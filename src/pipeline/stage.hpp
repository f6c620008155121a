// One step of a chain: what it needs, what decides its result, what it runs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::pipeline {

struct Stage {
    std::string name;
    std::vector<std::string> needs = {};     ///< stages whose results it reads
    core::Json configuration = {};                 ///< all settings that decide its result
    std::vector<core::Path> files = {};            ///< a user's files that it reads
    std::vector<std::string> outputs = {};   ///< files whose change makes it stale, "*.png" for all of a kind; result.json is always one
    std::function<core::Json(const core::Path& folder)> run;  ///< writes into `folder`, returns result.json
    std::function<std::string()> expect = [] { return std::string("seconds"); };  ///< for a dry run: what will run, memory and time
    bool resumes = false;     ///< run() resumes from what an interrupted run left in its folder; else that is removed
    long result_version = 1;  ///< raised when the stage's numbers can change: older results are stale then
    long seed = 0;            ///< for the manifest
    long processes = 1;       ///< for the manifest
    /// Files that are copied beside the stages' folders when the stage is done: name there, name in the stage's folder.
    std::vector<std::pair<std::string, std::string>> published = {};
};

}  // namespace porepack::pipeline
