// What runs, what is done already, and what a failure leaves.
#include <atomic>
#include <cmath>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/parallel.hpp"
#include "pipeline/pipeline.hpp"
#include "record/digest.hpp"
#include "record/manifest.hpp"
#include "support/basics.hpp"

namespace porepack {
using namespace record;
using namespace pipeline;
namespace {

using test::has;
using test::message_of;

// Two stages: `square` reads the output of `number`. They count their runs.
struct Chain {
    Path results;
    double value = 3.0;
    int runs_of_number = 0, runs_of_square = 0;
    bool fail = false;

    [[nodiscard]] Pipeline pipeline() {
        Stage number{.name = "number", .configuration = {{"value", value}}, .outputs = {"number.txt"}, .run = [this](const Path& folder) {
                         ++runs_of_number;
                         write_text(folder / "number.txt", std::to_string(value));
                         return Json{{"value", value}};
                     }};
        Stage square{.name = "square", .needs = {"number"}, .run = [this](const Path&) -> Json {
                         ++runs_of_square;
                         if (fail) throw NumericalError("the square is not found");
                         const double x = std::stod(read_text(results / "number" / "number.txt"));
                         return {{"square", x * x}};
                     }};
        square.published = {{"square.json", "result.json"}};
        return {.results = results, .stages = {number, square}};
    }
};

TEST(Pipeline, RunsWhatIsNotDoneAndOnlyThat) {
    const test::Folder folder;
    Chain chain{.results = folder.path() / "results"};
    EXPECT_EQ(run_pipeline(chain.pipeline()).at("square"), 9.0);
    EXPECT_TRUE(std::filesystem::exists(chain.results / "square.json"));
    EXPECT_EQ(run_pipeline(chain.pipeline()).at("square"), 9.0);
    EXPECT_EQ(chain.runs_of_number, 1);
    EXPECT_EQ(chain.runs_of_square, 1);
    chain.value = 4.0;
    EXPECT_EQ(status_of(chain.pipeline())[0].why, "configuration changed: value");
    EXPECT_EQ(status_of(chain.pipeline())[1].why, "number is stale");
    EXPECT_EQ(run_pipeline(chain.pipeline()).at("square"), 16.0);
    EXPECT_EQ(chain.runs_of_square, 2);
    EXPECT_TRUE(has(message_of<UserError>([&] { run_pipeline(chain.pipeline(), "cube"); }), "no stage cube"));
}

TEST(Pipeline, AHigherResultVersionMakesOldResultsStale) {
    const test::Folder folder;
    Chain chain{.results = folder.path() / "results"};
    run_pipeline(chain.pipeline());
    Pipeline newer = chain.pipeline();
    newer.stages[0].result_version = 2;
    EXPECT_TRUE(has(status_of(newer)[0].why, "result version 1"));
    run_pipeline(newer);
    EXPECT_EQ(chain.runs_of_number, 2);
    EXPECT_EQ(chain.runs_of_square, 2);  // the stage that depends on it, too
}

TEST(Pipeline, AFailedStageKeepsItsFolderAndStopsTheChain) {
    const test::Folder folder;
    Chain chain{.results = folder.path() / "results", .fail = true};
    EXPECT_THROW(run_pipeline(chain.pipeline()), NumericalError);
    EXPECT_EQ(status_of(chain.pipeline())[1].state, StageState::failed);
    EXPECT_FALSE(std::filesystem::exists(chain.results / "square"));
    chain.fail = false;
    EXPECT_EQ(run_pipeline(chain.pipeline()).at("square"), 9.0);
    EXPECT_EQ(chain.runs_of_number, 1);
}

TEST(Pipeline, AfterAnOptionalStageThatFailsTheOthersRun) {
    const test::Folder folder;
    Chain chain{.results = folder.path() / "results"};
    bool fail = false;
    int runs_of_report = 0;
    const auto pipeline = [&] {
        Pipeline p = chain.pipeline();
        Stage& square = p.stages.back();
        square.optional = true;
        square.configuration = {{"fail", chain.fail}};
        p.stages.push_back({.name = "report", .needs = {"number", "square"}, .run = [&](const Path&) -> Json {
                                ++runs_of_report;
                                if (fail) throw NumericalError("no report");
                                return {{"with_square", std::filesystem::exists(chain.results / "square")}};
                            }});
        return p;
    };
    EXPECT_EQ(run_pipeline(pipeline()).at("with_square"), true);
    // Its earlier result, which was out of date, is gone; the error comes at the end, and the stages after it are done.
    chain.fail = true;
    for (int run = 0; run < 2; ++run) {
        EXPECT_TRUE(has(message_of<NumericalError>([&] { run_pipeline(pipeline()); }), "the square is not found"));
        EXPECT_FALSE(std::filesystem::exists(chain.results / "square"));
        EXPECT_EQ(status_of(pipeline())[1].state, StageState::failed);
        EXPECT_EQ(status_of(pipeline())[2].state, StageState::done);
        EXPECT_EQ(read_json(chain.results / "report" / "result.json").at("with_square"), false);
        EXPECT_EQ(runs_of_report, 2);
        EXPECT_FALSE(is_done(pipeline(), "report"));
    }
    chain.fail = false;
    EXPECT_EQ(run_pipeline(pipeline()).at("with_square"), true);
    EXPECT_EQ(runs_of_report, 3);
    // A stage that is not optional still stops the chain.
    fail = true;
    chain.value = 5.0;
    EXPECT_TRUE(has(message_of<NumericalError>([&] { run_pipeline(pipeline()); }), "no report"));
}

TEST(Manifest, KnowsDoneStaleAndOfAnotherResultVersion) {
    const test::Folder folder;
    Manifest manifest{.stage = "lbm", .configuration = {{"a", 1}}, .inputs = {{"packing.json", "x"}}};
    EXPECT_EQ(state_of(folder.path(), manifest), StageState::missing);
    folder.write("k.txt", "1");
    folder.write("result.json", "{}");
    manifest.outputs["k.txt"] = sha256("1");
    write_json(folder.path() / "manifest.json", to_json(manifest));
    EXPECT_EQ(state_of(folder.path(), manifest), StageState::stale);  // the result beside it could be forged
    manifest.outputs["result.json"] = sha256("{}");
    write_json(folder.path() / "manifest.json", to_json(manifest));
    EXPECT_EQ(state_of(folder.path(), manifest), StageState::done);
    std::string why;
    Manifest changed = manifest;
    changed.inputs["packing.json"] = "y";
    EXPECT_EQ(state_of(folder.path(), changed, &why), StageState::stale);
    EXPECT_EQ(why, "input changed: packing.json");
    folder.write("k.txt", "2");
    EXPECT_EQ(state_of(folder.path(), manifest, &why), StageState::stale);
    EXPECT_EQ(why, "output changed or missing: k.txt");
    Json old = to_json(manifest);
    folder.write("k.txt", "1");
    old["program_version"] = "0.0.1";  // a new version alone does not make a stage stale
    write_json(folder.path() / "manifest.json", old);
    EXPECT_EQ(state_of(folder.path(), manifest, &why), StageState::done);
    // Entries of lists likewise; their number counts.
    EXPECT_EQ(given_values(Json::parse(R"({"list":[{"a":1,"b":0},{}],"x":[]})")), Json::parse(R"({"list":[{"a":1},{}]})"));
    Manifest with_new_keys = manifest;  // a later version's, at the values that stand for "not given"
    with_new_keys.configuration = {{"a", 1}, {"b", 0.0}, {"c", false}, {"d", ""}, {"e", Json::array()}, {"f", {{"g", nullptr}}}};
    EXPECT_EQ(state_of(folder.path(), with_new_keys, &why), StageState::done);
    with_new_keys.configuration["b"] = 2.0;
    EXPECT_EQ(state_of(folder.path(), with_new_keys, &why), StageState::stale);
    EXPECT_EQ(why, "configuration changed: b");
    Manifest newer = manifest;
    newer.result_version = 2;
    EXPECT_EQ(state_of(folder.path(), newer, &why), StageState::stale);
    EXPECT_TRUE(has(why, "result version 1, this porepack computes version 2"));
}

TEST(Context, AHostGetsLogAndProgressAndEndsTheWork) {
    std::vector<std::string> lines;
    bool stop = false;
    const Context run{
        .log = [&](LogLevel level,
                   std::string_view line) { lines.push_back((level == LogLevel::warning ? "warning: " : "") + std::string(line)); },
        .progress = {},
        .interrupted = [&] { return stop; }};
    const ContextScope scope(run);
    std::thread([] {  // another run in the same process: nothing of it comes here, on any of its threads
        std::atomic<int> heard = 0;
        const Context other{.log = [&](LogLevel, std::string_view) { ++heard; }, .progress = {}, .interrupted = {}};
        const ContextScope its(other);
        parallel_for(8, [](std::size_t) { log_info("of the other run"); });
        EXPECT_EQ(heard, 8);
    })
        .join();
    log_info("step {}", 1);
    log_warning("careful");
    EXPECT_EQ(lines, (std::vector<std::string>{"step 1", "warning: careful"}));
    const test::Folder folder;
    Chain chain{.results = folder.path() / "results"};
    stop = true;
    EXPECT_THROW(run_pipeline(chain.pipeline()), MachineError);
    EXPECT_EQ(chain.runs_of_number, 0);
}

}  // namespace
}  // namespace porepack
