#include "pipeline/pipeline.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>

#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/owned_names.hpp"
#include "core/process.hpp"
#include "pipeline/running_folder.hpp"
#include "record/digest.hpp"

namespace porepack::pipeline {
using namespace record;
namespace fs = std::filesystem;
namespace {

// The inputs of a stage are the digests of its files and of the results that it needs. The digest of a result covers the key of its stage,
// hence that stage's own inputs: a change anywhere before makes all later stages stale. The words for absent manifests match no digest.
std::map<std::string, std::string> digests_of(const Pipeline& pipeline, const Stage& stage) {
    std::map<std::string, std::string> digests;
    for (const auto& file : stage.files) {
        const std::string name = file.filename().string();
        digests[digests.contains(name) ? file.lexically_normal().string() : name] = sha256_of_file(file);
    }
    for (const auto& need : stage.needs) {
        const Path manifest = stage_folder(pipeline, need) / "manifest.json";
        if (!fs::exists(manifest)) {
            digests[need] = "missing";
            continue;
        }
        // Cost is not an input: result.json contains seconds, so the key of the stage is used instead.
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

Manifest expected_manifest(const Pipeline& pipeline, const Stage& stage) {
    return {.stage = stage.name,
            .result_version = stage.result_version,
            .configuration = stage.configuration,
            .inputs = digests_of(pipeline, stage),
            .seed = stage.seed,
            .processes = stage.processes};
}

Path failed_folder(const Pipeline& pipeline, const std::string& stage) {
    return pipeline.results / (stage + ".failed");
}

// An optional stage that failed: the stages that need it run without its result.
bool is_done_without(const Pipeline& pipeline, const std::string& need) {
    return std::any_of(pipeline.stages.begin(), pipeline.stages.end(), [&](const Stage& stage) {
        return stage.name == need && stage.optional && fs::exists(failed_folder(pipeline, need)) &&
               !fs::exists(stage_folder(pipeline, need));
    });
}

// Without the results that it needs, a stage cannot be compared with its manifest; what it left is stale. Failed and running folders count
// only where no complete result is current.
StageState state_in(const Pipeline& pipeline, const Stage& stage, std::string& why) {
    const Path folder = stage_folder(pipeline, stage.name);
    for (const auto& need : stage.needs)
        if (!fs::exists(stage_folder(pipeline, need) / "manifest.json") && !is_done_without(pipeline, need)) {
            why = "needs " + need;
            return fs::exists(folder) ? StageState::stale : StageState::missing;
        }
    const StageState state = state_of(folder, expected_manifest(pipeline, stage), &why);
    if (state == StageState::done) return state;
    if (fs::exists(failed_folder(pipeline, stage.name))) return StageState::failed;
    if (fs::exists(pipeline.results / ("." + stage.name + ".running"))) return StageState::running;
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

// Before the first stage runs: nothing of the user has the name of a result.
void require_room(const Pipeline& pipeline, const std::vector<const Stage*>& stages) {
    for (const Stage* stage : stages)
        for (const Path& folder : {stage_folder(pipeline, stage->name), failed_folder(pipeline, stage->name)}) require_own(folder);
    // Results of before that have no list of names yet.
    if (std::any_of(pipeline.stages.begin(), pipeline.stages.end(),
                    [&](const Stage& stage) { return fs::exists(stage_folder(pipeline, stage.name) / "manifest.json"); }))
        return;
    const OwnedNames owned(pipeline.results);
    for (const Stage* stage : stages)
        for (const auto& [name, source] : stage->published) owned.require(name);
}

void publish(const Pipeline& pipeline, const Stage& stage) {
    OwnedNames owned(pipeline.results);
    std::vector<std::string> names;
    for (const auto& [name, source] : stage.published) names.push_back(name);
    owned.add(names);
    for (const auto& [name, source] : stage.published) {
        const Path target = pipeline.results / name;
        const std::string text = read_text(stage_folder(pipeline, stage.name) / source);
        if (!fs::exists(target) || read_text(target) != text) write_text(target, text);
    }
}

// A stage that fails keeps its folder as .failed.
Json run_stage(const Pipeline& pipeline, const Stage& stage, const std::string& number) {
    // A result appears in one step: the stage works in a hidden folder, the manifest is written last, and the folder is then renamed. A
    // stage that is interrupted leaves the old result untouched. The inputs' digests are taken before the run: a file that changes during
    // the run makes the result stale.
    const Path running = pipeline.results / ("." + stage.name + ".running"), final = stage_folder(pipeline, stage.name),
               failed = failed_folder(pipeline, stage.name);
    if (!stage.resumes) fs::remove_all(running);
    fs::remove_all(failed);
    make_folder(running);
    mark_as_own(running);
    log_info("{}: runs, stage {}", stage.name, number);
    reset_peak_memory();
    (void)take_peak_program_memory_bytes();
    const Stopwatch watch;
    Manifest manifest = expected_manifest(pipeline, stage);
    try {
        Json result = stage.run(running);
        check_interrupt();
        result["wall_time_s"] = watch.seconds();
        write_json(running / "result.json", result);
        for (const auto& name : files_in(running, stage.outputs)) manifest.outputs[name] = sha256_of_file(running / name);
        manifest.versions = pipeline.versions();
        manifest.wall_time_s = watch.seconds();
        manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
        write_json(running / "manifest.json", to_json(manifest));
        fs::remove_all(final);
        fs::rename(running, final);
        log_info("{}: done in {}", stage.name, human_time(manifest.wall_time_s));
        if (result.contains("repeat_by_hand"))
            log_info("{}: by hand: cd {} && {}", stage.name, for_shell(fs::absolute(final).lexically_normal().string()),
                     result["repeat_by_hand"].get<std::string>());
        return result;
    } catch (...) {
        keep_what_is_left(running, failed, stage.resumes);
    }
}

// The stages that `last` needs, in order.
std::vector<const Stage*> stages_up_to(const Pipeline& pipeline, const std::string& last) {
    if (pipeline.stages.empty()) throw std::logic_error("a pipeline without stages");
    const std::string wanted = last.empty() ? pipeline.stages.back().name : last;
    // Each stage stands after those that it needs, so one pass from the last to the first collects all of them.
    std::set<std::string> needed = {wanted};
    bool found = false;
    for (auto stage = pipeline.stages.rbegin(); stage != pipeline.stages.rend(); ++stage) {
        found = found || stage->name == wanted;
        if (needed.contains(stage->name)) needed.insert(stage->needs.begin(), stage->needs.end());
    }
    if (!found) throw UserError("this case has no stage " + wanted, {.fix = pipeline.left_out});
    std::vector<const Stage*> stages;
    for (const Stage& stage : pipeline.stages)
        if (needed.contains(stage.name)) stages.push_back(&stage);
    return stages;
}

}  // namespace

Path stage_folder(const Pipeline& pipeline, const std::string& stage) {
    return pipeline.results / stage;
}

std::vector<StageStatus> status_of(const Pipeline& pipeline) {
    std::vector<StageStatus> list;
    for (const Stage& stage : pipeline.stages) {
        StageStatus status{.name = stage.name};
        status.state = state_in(pipeline, stage, status.why);
        // The manifest proves agreement with the results that are there; a stage whose inputs are stale themselves is stale too.
        if (status.state == StageState::done) {
            status.wall_time_s = read_json(stage_folder(pipeline, stage.name) / "manifest.json").value("wall_time_s", 0.0);
            for (const auto& need : stage.needs)
                for (const auto& other : list)
                    if (other.name == need && other.state != StageState::done && !is_done_without(pipeline, need)) {
                        status.state = StageState::stale;
                        status.why = fmt::format("{} is {}", other.name, name_of(other.state));
                    }
        }
        list.push_back(status);
    }
    return list;
}

bool is_done(const Pipeline& pipeline, const std::string& last) {
    const std::vector<const Stage*> stages = stages_up_to(pipeline, last);
    return std::all_of(stages.begin(), stages.end(), [&](const Stage* stage) {
        std::string why;
        return state_in(pipeline, *stage, why) == StageState::done;
    });
}

Json identity_of(const Pipeline& pipeline, const std::string& last) {
    Json stages = Json::array();
    for (const Stage* stage : stages_up_to(pipeline, last)) {
        Json files = Json::object();
        for (const Path& file : stage->files) files[file.filename().string()] = sha256_of_file(file);
        stages.push_back({{"stage", stage->name},
                          {"result_version", stage->result_version},
                          {"configuration", given_values(stage->configuration)},
                          {"files_sha256", files}});
    }
    return stages;
}

Json run_pipeline(const Pipeline& pipeline, const std::string& last) {
    const FileLock lock = locked(pipeline.results);
    Json result;
    std::exception_ptr failure;
    const std::vector<const Stage*> stages = stages_up_to(pipeline, last);
    require_room(pipeline, stages);
    // By reference: the address in `stages` gives the number of the stage.
    for (const Stage* const& stage : stages) {
        check_interrupt();
        std::string why;
        const StageState state = state_in(pipeline, *stage, why);
        if (state == StageState::done) {
            log_info("{}: already done", stage->name);
            result = read_json(stage_folder(pipeline, stage->name) / "result.json");
        } else {
            if (state == StageState::stale) log_info("{}: done before, but {}", stage->name, why);
            try {
                result = run_stage(pipeline, *stage, fmt::format("{} of {}", &stage - stages.data() + 1, stages.size()));
            } catch (const Error&) {
                // An interruption is no failure of the stage.
                if (!stage->optional || interrupted()) throw;
                fs::remove_all(stage_folder(pipeline, stage->name));
                log_warning(fmt::format("{} failed; the other stages run without its result", stage->name));
                failure = std::current_exception();
                continue;
            }
        }
        // Also for stages that were done: their published files may have been changed or removed.
        publish(pipeline, *stage);
    }
    if (failure) std::rethrow_exception(failure);
    return result;
}

namespace {

// visit(stage, state, what it needs if it is not done).
template <typename Visit>
void for_expected(const Pipeline& pipeline, const std::string& last, const Visit& visit) {
    for (const Stage* stage : stages_up_to(pipeline, last)) {
        std::string why;
        const StageState state = state_in(pipeline, *stage, why);
        visit(*stage, state, state == StageState::done ? Expectation{.text = "nothing"} : stage->expect());
    }
}

void add(Expectation& all, const Expectation& expected) {
    all.memory_bytes = std::max(all.memory_bytes, expected.memory_bytes);
    all.wall_time_s += expected.wall_time_s;
    all.disk_bytes += expected.disk_bytes;
}

}  // namespace

Expectation expected_of(const Pipeline& pipeline, const std::string& last) {
    Expectation all;
    for_expected(pipeline, last, [&](const Stage&, StageState, const Expectation& expected) { add(all, expected); });
    return all;
}

Json plan_pipeline(const Pipeline& pipeline, const std::string& last, double slowness) {
    require_room(pipeline, stages_up_to(pipeline, last));
    Json plan = {{"stages", Json::array()}};
    Expectation all;
    const double memory = available_memory_bytes();
    for_expected(pipeline, last, [&](const Stage& stage, StageState state, const Expectation& expected) {
        add(all, expected);
        if (memory > 0.0 && expected.memory_bytes > memory)
            log_warning(fmt::format("{} needs about {} of memory, and {} are free: it will not run here", stage.name,
                                    human_bytes(expected.memory_bytes), human_bytes(memory)));
        plan["stages"].push_back({{"stage", stage.name},
                                  {"state", name_of(state)},
                                  {"would_run", state != StageState::done},
                                  {"expected", text_of(expected, slowness)}});
    });
    plan["expected"] = text_of(all, slowness);
    plan["memory_available"] = human_bytes(memory);
    // Before the first run the folder does not exist: its nearest parent is on the same disk.
    Path disk = fs::absolute(pipeline.results);
    while (!fs::exists(disk)) disk = disk.parent_path();
    const auto room = static_cast<double>(fs::space(disk).available);
    if (all.disk_bytes > room)
        log_warning(fmt::format("the results need about {} of disk, and {} are free", human_bytes(all.disk_bytes), human_bytes(room)));
    plan["disk_available"] = human_bytes(room);
    return plan;
}

}  // namespace porepack::pipeline
