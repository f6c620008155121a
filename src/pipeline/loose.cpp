#include "pipeline/loose.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <optional>

#include "core/digest.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "pipeline/manifest.hpp"
#include "pipeline/running_folder.hpp"

namespace porepack::pipeline {
using namespace core;
namespace fs = std::filesystem;
namespace {

// Distinguishes a folder that a loose stage may replace from a folder of the user.
constexpr const char* owner_mark = ".porepack";

void write_manifest(const LooseRun& run, const Path& running, const Json& result, double seconds) {
    Manifest manifest{.stage = run.stage, .configuration = run.configuration};
    for (const auto& input : run.inputs)
        if (!fs::is_directory(input)) manifest.inputs[input.filename().string()] = sha256_of_file(input);
    manifest.versions = run.versions();
    write_json(running / (run.stage + ".result.json"), result);
    for (const auto& entry : fs::recursive_directory_iterator(running))
        if (entry.is_regular_file()) manifest.outputs[entry.path().lexically_relative(running).string()] = sha256_of_file(entry.path());
    for (const auto& entry : fs::directory_iterator(running))
        if (entry.is_directory())
            write_text(entry.path() / owner_mark, "This folder was written by porepack and is replaced as a whole.\n");
    manifest.wall_time_s = seconds;
    manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
    write_json(running / (run.stage + ".manifest.json"), to_json(manifest));
}

void move_into_place(const LooseRun& run, const Path& running) {
    for (const auto& entry : fs::directory_iterator(running)) {
        const Path there = run.target / entry.path().filename();
        for (const auto& input : run.inputs)
            if (std::error_code none; fs::equivalent(there, input, none))
                throw UserError("the result would overwrite its own input " + there.string(),
                                {.fix = "choose another folder with --output"});
        if (fs::is_directory(there)) {
            if (!fs::exists(there / owner_mark))
                throw UserError("the folder " + there.string() + " is in the way and was not written by porepack",
                                {.fix = "move it, or choose another folder with --output"});
            fs::remove_all(there);
        }
        fs::rename(entry.path(), there);
    }
    fs::remove_all(running);
}

}  // namespace

Json run_loose(const LooseRun& run) {
    const bool fresh = !fs::exists(run.target);
    require_writable(run.target);
    const Path running =
        run.target / (run.resumes ? fmt::format(".{}.running", run.stage) : fmt::format(".{}.{}.running", run.stage, getpid()));
    make_folder(running);
    std::optional<FileLock> lock;
    if (run.resumes) lock.emplace(locked(running));
    const Stopwatch watch;
    const auto clean_up = [&] {
        std::error_code ignored;
        fs::remove_all(running, ignored);
        if (fresh) fs::remove(run.target, ignored);  // if it is empty
    };
    try {
        Json result = run.work(running);
        check_interrupt();
        lock.reset();
        fs::remove(running / ".lock");
        result["wall_time_s"] = watch.seconds();
        write_manifest(run, running, result, watch.seconds());
        move_into_place(run, running);
        return result;
    } catch (const Error& error) {
        // The logs of an engine are kept.
        if (error.code() == ExitCode::engine || (run.resumes && interrupted()))
            keep_what_is_left(running, run.target / (run.stage + ".failed"), run.resumes);
        clean_up();
        throw;
    } catch (...) {
        clean_up();
        throw;
    }
}

}  // namespace porepack::pipeline
