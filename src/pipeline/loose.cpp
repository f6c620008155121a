#include "pipeline/loose.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/owned_names.hpp"
#include "core/process.hpp"
#include "pipeline/running_folder.hpp"
#include "record/digest.hpp"
#include "record/manifest.hpp"

namespace porepack::pipeline {
using namespace record;
namespace fs = std::filesystem;
namespace {

void write_manifest(const LooseRun& run, Manifest manifest, const Path& running, const Json& result, double seconds) {
    manifest.versions = run.versions();
    write_json(running / (run.stage + ".result.json"), result);
    for (const auto& entry : fs::recursive_directory_iterator(running))
        if (entry.is_regular_file()) manifest.outputs[entry.path().lexically_relative(running).string()] = sha256_of_file(entry.path());
    for (const auto& entry : fs::directory_iterator(running))
        if (entry.is_directory()) mark_as_own(entry.path());
    manifest.wall_time_s = seconds;
    manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
    write_json(running / (run.stage + ".manifest.json"), to_json(manifest));
}

// The folder where the result stays if something of the user is in its way.
Path spare_folder(const LooseRun& run) {
    for (int n = 1;; ++n)
        if (Path spare = run.target / fmt::format("{}_{}", run.stage, n); !fs::exists(spare)) return spare;
}

// Everything or, where one name is in the way, nothing.
void move_into_place(const LooseRun& run, const Path& running) {
    OwnedNames owned(run.target);
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(running)) names.push_back(entry.path().filename().string());
    try {
        for (const std::string& name : names) {
            for (const auto& input : run.inputs)
                if (std::error_code none; fs::equivalent(run.target / name, input, none))
                    throw UserError("the result would overwrite its own input " + (run.target / name).string(),
                                    {.fix = "choose another folder with --output"});
            owned.require(name);
        }
    } catch (const UserError& error) {
        const Path spare = spare_folder(run);
        fs::rename(running, spare);
        throw UserError(fmt::format("{}\nThe result is kept in {}.", error.what(), spare.string()));
    }
    owned.add(names);
    for (const std::string& name : names) {
        fs::remove_all(run.target / name);
        fs::rename(running / name, run.target / name);
    }
    fs::remove_all(running);
}

// What this stage wrote here before a kill; a process that runs holds the lock.
void remove_litter(const LooseRun& run) {
    const std::string first = fmt::format(".{}.", run.stage);
    for (const auto& entry : fs::directory_iterator(run.target)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(first) || !name.ends_with(".running") || !is_own(entry.path())) continue;
        if (const auto lock = FileLock::try_take(entry.path() / ".lock")) fs::remove_all(entry.path());
    }
}

}  // namespace

Json run_loose(const LooseRun& run) {
    const bool fresh = !fs::exists(run.target);
    require_writable(run.target);
    OwnedNames before(run.target);
    for (const char* kind : {".result.json", ".manifest.json"}) before.require(run.stage + kind);
    const Path failed = run.target / (run.stage + ".failed");
    require_own(failed);
    if (!run.resumes) remove_litter(run);
    const Path running =
        run.target / (run.resumes ? fmt::format(".{}.running", run.stage) : fmt::format(".{}.{}.running", run.stage, getpid()));
    make_folder(running);
    std::optional<FileLock> lock(locked(running));
    mark_as_own(running);
    const Stopwatch watch;
    Manifest manifest{.stage = run.stage, .configuration = run.configuration};
    const auto clean_up = [&] {
        std::error_code ignored;
        fs::remove_all(running, ignored);
        if (fresh) fs::remove(run.target, ignored);  // if it is empty
    };
    try {
        // Of what is read now; the user may replace it while the stage runs.
        for (const auto& input : run.inputs)
            if (!fs::is_directory(input)) manifest.inputs[input.filename().string()] = sha256_of_file(input);
        Json result = run.work(running);
        check_interrupt();
        fs::remove(running / ".porepack");  // while the lock is held: a marked folder without a lock is litter
        lock.reset();
        fs::remove(running / ".lock");
        result["wall_time_s"] = watch.seconds();
        write_manifest(run, manifest, running, result, watch.seconds());
        move_into_place(run, running);
        return result;
    } catch (const Error& error) {
        // The logs of an engine are kept.
        if (error.code() == ExitCode::engine || (run.resumes && interrupted())) keep_what_is_left(running, failed, run.resumes);
        clean_up();
        throw;
    } catch (...) {
        clean_up();
        throw;
    }
}

}  // namespace porepack::pipeline
