// The hidden folder of a stage that runs, and the lock that keeps two processes from one place. Only for the sources of this folder.
#pragma once

#include "core/files.hpp"

namespace porepack::pipeline {

/// One process at a time. Throws UserError when another one holds it.
class Lock {
public:
    explicit Lock(const core::Path& folder);
    ~Lock();
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

private:
    int file_ = -1;
};

/// In a catch block: ends a stage and throws on. A stage that failed keeps its folder under the name `failed`, and the message names its
/// files where they now are; one that was interrupted leaves nothing, unless it can resume from it.
[[noreturn]] void keep_what_is_left(const core::Path& running, const core::Path& failed, bool resumes);

}  // namespace porepack::pipeline
