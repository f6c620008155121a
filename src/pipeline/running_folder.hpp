// The hidden folder of a running stage, and the lock that prevents two processes in one folder. Only for the sources of this folder.
#pragma once

#include "core/file_lock.hpp"
#include "core/files.hpp"

namespace porepack::pipeline {

/// One process at a time. Throws UserError when another one holds it.
[[nodiscard]] core::FileLock locked(const core::Path& folder);

/// In a catch block: ends a stage and rethrows. A failed stage keeps its folder under the name `failed`, and the message names its
/// files at their new location; an interrupted stage leaves no folder, unless it can resume from it.
[[noreturn]] void keep_what_is_left(const core::Path& running, const core::Path& failed, bool resumes);

}  // namespace porepack::pipeline
