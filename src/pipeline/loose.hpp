// One stage on loose files, outside any case.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack {

struct LooseRun {
    std::string stage;
    Path target;                                   ///< folder for the results
    Json configuration = {};                       ///< for the manifest
    std::vector<Path> inputs = {};                 ///< for the manifest; a result never overwrites one of them
    std::function<Json(const Path& folder)> work;  ///< writes into `folder`, returns the result
    bool resumes = false;                          ///< `work` finds its folder again after it was interrupted
    std::function<Json()> versions = [] { return Json::object(); };
};

/// Runs `work` in a temporary folder inside the target, writes <stage>.result.json and <stage>.manifest.json beside its files and moves all
/// of them into the target, replacing what has the same name. Throws UserError when a folder of the user's own is in the way.
Json run_loose(const LooseRun& run);

}  // namespace porepack
