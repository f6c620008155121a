#include "pipeline/running_folder.hpp"

#include <filesystem>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/throw_as.hpp"

namespace porepack::pipeline {
namespace fs = std::filesystem;

FileLock locked(const Path& folder) {
    require_writable(folder);
    auto lock = FileLock::try_take(folder / ".lock");
    if (!lock) throw UserError("another porepack runs here", {.where = folder.string(), .fix = "wait for it, or end it"});
    return std::move(*lock);
}

void keep_what_is_left(const Path& running, const Path& failed, bool resumes) {
    // The exception in flight is thrown again to find its type. Errors of the file system are ignored here: they must not hide the cause.
    // The message names files of the running folder, which has just been renamed, so their paths are replaced; a new error of the same type
    // keeps the exit code.
    std::error_code ignored;
    try {
        throw;
    } catch (const Error& error) {
        if (interrupted()) {
            if (!resumes) fs::remove_all(running, ignored);
            throw;
        }
        fs::remove_all(failed, ignored);
        fs::rename(running, failed, ignored);
        std::string text = error.what();
        for (std::size_t at = 0; (at = text.find(running.string(), at)) != std::string::npos; at += failed.string().size())
            text.replace(at, running.string().size(), failed.string());
        throw_as(error.code(), text);
    } catch (...) {
        fs::remove_all(running, ignored);
        throw;
    }
}

}  // namespace porepack::pipeline
