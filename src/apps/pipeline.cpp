#include "apps/pipeline.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <set>

#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "openfoam/foam.hpp"
#include "packing/liggghts.hpp"
#include "permeability/permeability.hpp"
#include "report/report.hpp"

namespace porepack {
namespace fs = std::filesystem;
namespace {

Path folder_of(const Case& c, const std::string& stage) {
    return c.results() / stage;
}

std::string shell_quoted(const std::string& text) {
    if (text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:=") == std::string::npos) return text;
    std::string quoted = "'";
    for (const char ch : text) quoted += ch == '\'' ? std::string("'\\''") : std::string(1, ch);
    return quoted + "'";
}

std::map<std::string, std::string> digests_of(const Case& c, const Stage& stage) {
    std::map<std::string, std::string> digests;
    for (const auto& file : stage.files) digests[file.filename().string()] = sha256_of_file(file);
    for (const auto& need : stage.needs) {
        const Path manifest = folder_of(c, need) / "manifest.json";
        if (!fs::exists(manifest)) {
            digests[need] = "missing";
            continue;
        }
        // Cost is no input: result.json holds seconds, so the key of the stage stands for it.
        try {
            const Json content = read_json(manifest);
            Json outputs = content.at("outputs_sha256");
            outputs.erase("result.json");
            digests[need] = sha256(content.at("key").get<std::string>() + outputs.dump());
        } catch (const std::exception&) {
            digests[need] = "unreadable";
        }
    }
    return digests;
}

Manifest expected_manifest(const Case& c, const Stage& stage) {
    Manifest manifest{.stage = stage.name, .result_version = stage.result_version, .configuration = stage.configuration};
    manifest.inputs = digests_of(c, stage);
    manifest.seed = c.settings.packing.seed;
    manifest.processes = stage.name == "pack" ? c.settings.packing.processes : 1;
    return manifest;
}

StageState state_in(const Case& c, const Stage& stage, std::string* why) {
    for (const auto& need : stage.needs)
        if (!fs::exists(folder_of(c, need) / "manifest.json")) {
            if (why != nullptr) *why = "needs " + need;
            return fs::exists(folder_of(c, stage.name)) ? StageState::stale : StageState::missing;
        }
    const StageState state = state_of(folder_of(c, stage.name), expected_manifest(c, stage), why);
    if (state == StageState::done) return state;
    if (fs::exists(c.results() / (stage.name + ".failed"))) return StageState::failed;
    if (fs::exists(c.results() / ("." + stage.name + ".running"))) return StageState::running;
    return state;
}

std::vector<std::string> files_in(const Path& folder, const std::vector<std::string>& patterns) {
    std::vector<std::string> names = {"result.json"};
    for (const auto& pattern : patterns) {
        if (pattern.front() != '*') {
            names.push_back(pattern);
            continue;
        }
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == pattern.substr(1)) names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin() + 1, names.end());
    return names;
}

// In a catch block: ends the stage and throws on. A failed stage keeps its folder, and the message names files where they
// now are; an interrupted one leaves nothing, unless it can go on from it.
[[noreturn]] void keep_what_is_left(const Path& running, const Path& failed, bool goes_on) {
    std::error_code ignored;
    try {
        throw;
    } catch (const Error& error) {
        if (interrupted()) {
            if (!goes_on) fs::remove_all(running, ignored);
            throw;
        }
        fs::remove_all(failed, ignored);
        fs::rename(running, failed, ignored);
        std::string text = error.what();
        for (std::size_t at = 0; (at = text.find(running.string(), at)) != std::string::npos; at += failed.string().size())
            text.replace(at, running.string().size(), failed.string());
        throw Error(error.code(), text);
    } catch (...) {
        fs::remove_all(running, ignored);
        throw;
    }
}

// A stage that fails keeps its folder as .failed.
Json run_stage(const Case& c, const Stage& stage) {
    const Path running = c.results() / ("." + stage.name + ".running"), final = folder_of(c, stage.name),
               failed = c.results() / (stage.name + ".failed");
    if (!stage.goes_on) fs::remove_all(running);
    fs::remove_all(failed);
    make_folder(running);
    log_info("{}: runs", stage.name);
    reset_peak_memory();
    (void)take_peak_program_memory_bytes();
    const Stopwatch watch;
    Manifest manifest = expected_manifest(c, stage);
    try {
        const Json result = stage.run(running);
        check_interrupt();
        Json whole = result;
        whole["wall_time_s"] = watch.seconds();
        write_json(running / "result.json", whole);
        for (const auto& name : files_in(running, stage.outputs)) manifest.outputs[name] = sha256_of_file(running / name);
        manifest.versions = engine_versions();
        manifest.wall_time_s = watch.seconds();
        manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
        write_json(running / "manifest.json", to_json(manifest));
        fs::remove_all(final);
        fs::rename(running, final);
        log_info("{}: done in {}", stage.name, human_time(manifest.wall_time_s));
        if (whole.contains("repeat_by_hand"))
            log_info("{}: by hand: cd {} && {}", stage.name, shell_quoted(fs::absolute(final).lexically_normal().string()),
                     whole["repeat_by_hand"].get<std::string>());
        return whole;
    } catch (...) {
        keep_what_is_left(running, failed, stage.goes_on);
    }
}

// One run at a time in a case.
class Lock {
public:
    explicit Lock(const Path& results) {
        require_writable(results);
        file_ = open((results / ".lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
        if (file_ < 0 || flock(file_, LOCK_EX | LOCK_NB) != 0)
            throw UserError("another porepack runs here", {.where = results.string(), .mend = "wait for it, or end it"});
    }
    ~Lock() {
        if (file_ >= 0) close(file_);
    }
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

private:
    int file_ = -1;
};

// The stages that `last` needs, in order; what the report needs when empty.
std::vector<Stage> stages_up_to(const Case& c, const std::string& last) {
    auto all = stages_of(c);
    std::set<std::string> wanted = {last.empty() ? "report" : last};
    for (auto stage = all.rbegin(); stage != all.rend(); ++stage)
        if (wanted.contains(stage->name)) wanted.insert(stage->needs.begin(), stage->needs.end());
    if (std::none_of(all.begin(), all.end(), [&](const Stage& stage) { return wanted.contains(stage.name); }))
        throw UserError(
            "this case has no stage " + last,
            {.mend =
                 "stages that a case leaves out: foam ([openfoam] enabled), forchheimer ([forchheimer] enabled), causes ([falling_head] "
                 "causes), seeds ([packing] seeds), pack (of an STL file)"});
    std::erase_if(all, [&](const Stage& stage) { return !wanted.contains(stage.name); });
    return all;
}

}  // namespace

std::vector<StageStatus> status_of(const Case& c) {
    std::vector<StageStatus> list;
    for (const auto& stage : stages_of(c)) {
        StageStatus status{.name = stage.name, .state = StageState::missing, .why = {}};
        status.state = state_in(c, stage, &status.why);
        if (status.state == StageState::done) {
            status.wall_time_s = read_json(folder_of(c, stage.name) / "manifest.json").value("wall_time_s", 0.0);
            for (const auto& need : stage.needs)
                for (const auto& other : list)
                    if (other.name == need && other.state != StageState::done) {
                        status.state = StageState::stale;
                        status.why = other.name + " is " + name_of(other.state);
                    }
        }
        list.push_back(status);
    }
    return list;
}

Json run_case(const Case& c, const std::string& last) {
    const Lock lock(c.results());
    Json result;
    for (const auto& stage : stages_up_to(c, last)) {
        check_interrupt();
        std::string why;
        const StageState state = state_in(c, stage, &why);
        if (state == StageState::done) {
            log_info("{}: already done", stage.name);
            result = read_json(folder_of(c, stage.name) / "result.json");
        } else {
            if (state == StageState::stale) log_info("{}: done before, but {}", stage.name, why);
            result = run_stage(c, stage);
        }
        if (stage.name == "report")
            for (const char* name : {"report.html", "report.md", "result.json"}) {
                // The report's pictures lie beside it in results/report; the page itself holds all of them.
                const Path source =
                    std::string(name) == "result.json" ? folder_of(c, "report") / "merged.json" : folder_of(c, "report") / name;
                const std::string text = read_text(source);
                if (!fs::exists(c.results() / name) || read_text(c.results() / name) != text) write_text(c.results() / name, text);
            }
    }
    return result;
}

Json plan_case(const Case& c, const std::string& last) {
    Json plan = {{"configuration", Json::object()}, {"stages", Json::array()}};
    Case copy = c;
    for (const auto& table : Settings::tables()) plan["configuration"][table] = to_json(copy.settings.describe_table(table));
    for (const auto& stage : stages_up_to(c, last)) {
        std::string why;
        const StageState state = state_in(c, stage, &why);
        plan["stages"].push_back({{"stage", stage.name},
                                  {"state", name_of(state)},
                                  {"would_run", state != StageState::done},
                                  {"expected", state == StageState::done ? "nothing" : stage.expect()}});
    }
    plan["memory_available"] = human_bytes(available_memory_bytes());
    return plan;
}

Json engine_versions() {
    static const Json versions = {{"liggghts", first_line_of("liggghts -log none -h")},
                                  {"openfoam", first_line_of("dpkg-query -W -f '${Version}' openfoam")},
                                  {"mpirun", first_line_of("mpirun --version")},
                                  {"gnuplot", first_line_of("gnuplot --version")}};
    return versions;
}

namespace {

// Tells a folder that a loose stage may replace from one of the user's own.
constexpr const char* owner_mark = ".porepack";

}  // namespace

Json run_loose(const std::string& stage, const Path& target, const Json& configuration, const std::vector<Path>& inputs,
               const std::function<Json(const Path&)>& work, bool goes_on) {
    const bool fresh = !fs::exists(target);
    require_writable(target);
    const Path running = target / (goes_on ? fmt::format(".{}.running", stage) : fmt::format(".{}.{}.running", stage, getpid()));
    make_folder(running);
    std::optional<Lock> lock;
    if (goes_on) lock.emplace(running);
    const Stopwatch watch;
    const auto clean_up = [&] {
        std::error_code ignored;
        fs::remove_all(running, ignored);
        if (fresh) fs::remove(target, ignored);  // where it is empty
    };
    try {
        Json result = work(running);
        check_interrupt();
        lock.reset();
        fs::remove(running / ".lock");
        result["wall_time_s"] = watch.seconds();
        Manifest manifest{.stage = stage, .result_version = 1, .configuration = configuration};
        for (const auto& input : inputs)
            if (!fs::is_directory(input)) manifest.inputs[input.filename().string()] = sha256_of_file(input);
        manifest.versions = engine_versions();
        write_json(running / (stage + ".result.json"), result);
        for (const auto& entry : fs::directory_iterator(running))
            if (entry.is_regular_file())
                manifest.outputs[entry.path().filename().string()] = sha256_of_file(entry.path());
            else if (entry.is_directory())
                write_text(entry.path() / owner_mark, "This folder was written by porepack and is replaced as a whole.\n");
        manifest.wall_time_s = watch.seconds();
        manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
        write_json(running / (stage + ".manifest.json"), to_json(manifest));
        for (const auto& entry : fs::directory_iterator(running)) {
            const Path there = target / entry.path().filename();
            for (const auto& input : inputs)
                if (std::error_code none; fs::equivalent(there, input, none))
                    throw UserError("the result would overwrite its own input " + there.string(),
                                    {.mend = "choose another folder with --output"});
            if (fs::is_directory(there)) {
                if (!fs::exists(there / owner_mark))
                    throw UserError("the folder " + there.string() + " is in the way and was not written by porepack",
                                    {.mend = "move it, or choose another folder with --output"});
                fs::remove_all(there);
            }
            fs::rename(entry.path(), there);
        }
        fs::remove_all(running);
        return result;
    } catch (const Error& error) {
        // An engine's logs are worth keeping.
        if (error.code() == ExitCode::engine || (goes_on && interrupted()))
            keep_what_is_left(running, target / (stage + ".failed"), goes_on);
        clean_up();
        throw;
    } catch (...) {
        clean_up();
        throw;
    }
}

}  // namespace porepack
