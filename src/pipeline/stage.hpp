// One stage of a chain: what it needs, what determines its result, what it runs.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/expectation.hpp"
#include "core/files.hpp"
#include "core/members.hpp"
#include "core/members_json.hpp"

namespace porepack::pipeline {

struct Stage {
    std::string name;
    std::vector<std::string> needs = {};        ///< stages whose results it reads
    core::Json configuration = {};              ///< all settings that determine its result
    std::vector<core::Path> files = {};         ///< files of the user that it reads
    std::vector<std::string> outputs = {};      ///< files whose change makes it stale, "*.png" for all such; result.json is always included
    core::JsonFunction<const core::Path&> run;  ///< writes into the folder, returns what result.json holds
    std::function<core::Expectation()> expect = [] { return core::Expectation{.text = "seconds"}; };  ///< for a dry run
    bool optional = false;    ///< if it fails, the stages that need it run without its result
    bool resumes = false;     ///< run() resumes from the files of an interrupted run in its folder; else they are removed
    long result_version = 1;  ///< raised when the stage's numbers can change: older results are stale then
    long seed = 0;            ///< for the manifest
    long processes = 1;       ///< for the manifest
    /// Files that are copied next to the stages' folders when the stage is done: name there, name in the stage's folder.
    std::vector<std::pair<std::string, std::string>> published = {};
};

}  // namespace porepack::pipeline
