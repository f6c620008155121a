// The runner of stages, the tables and the context, in-process.
#include "pipeline/pipeline.hpp"

#include <cmath>

#include "core/context.hpp"
#include "core/log.hpp"
#include "core/members.hpp"
#include "core/table.hpp"
#include "record/toml_file.hpp"
#include "stages/case.hpp"
#include "support/helpers.hpp"

namespace porepack {
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

TEST(Context, AHostGetsLogAndProgressAndEndsTheWork) {
    std::vector<std::string> lines;
    bool stop = false;
    set_context(
        {.log = [&](LogLevel level,
                    std::string_view line) { lines.push_back((level == LogLevel::warning ? "warning: " : "") + std::string(line)); },
         .progress = {},
         .interrupted = [&] { return stop; }});
    log_info("step {}", 1);
    log_warning("careful");
    EXPECT_EQ(lines, (std::vector<std::string>{"step 1", "warning: careful"}));
    const test::Folder folder;
    Chain chain{.results = folder.path() / "results"};
    stop = true;
    EXPECT_THROW(run_pipeline(chain.pipeline()), MachineError);
    EXPECT_EQ(chain.runs_of_number, 0);
    set_context({});
}

TEST(Table, WritesNumbersTextAndWhatIsNotKnown) {
    Table table({"name", "value_m", "count"});
    table.digits = 4;
    table.add("a, \"b\"", 1.23456, 123456);
    table.add("c", std::nan(""), 0);
    EXPECT_EQ(table.csv(), "name,value_m,count\n\"a, \"\"b\"\"\",1.235,123456\nc,,0\n");
    EXPECT_THROW(table.add("too few"), std::logic_error);
}

struct Part {
    double length_m = 0.0;
    std::optional<double> error;
};
template <MembersOf<Part> Self, typename Visit>
void visit_members(Self& part, const Visit& visit) {
    visit("length_m", part.length_m);
    visit("error", part.error);
}
struct Whole {
    std::vector<Part> parts;
    Interval interval;
    std::string name;
};
template <MembersOf<Whole> Self, typename Visit>
void visit_members(Self& whole, const Visit& visit) {
    visit("parts", whole.parts);
    visit("interval", whole.interval);
    visit("name", whole.name);
}

struct Flattened {
    OptionalKey<Part> part;
    OptionalKey<double> slope;
    ByName<long> counts;
    double unknown = std::numeric_limits<double>::quiet_NaN();
};
template <MembersOf<Flattened> Self, typename Visit>
void visit_members(Self& flattened, const Visit& visit) {
    visit("", flattened.part);
    visit("slope", flattened.slope);
    visit("counts", flattened.counts);
    visit("unknown", flattened.unknown);
    double twice = flattened.slope ? 2.0 * *flattened.slope : 0.0;
    visit("twice", twice);
}

TEST(Members, GoToJsonAndBack) {
    const Whole whole{.parts = {{0.1, std::nullopt}, {0.2, 1e-3}}, .interval = {1.0, 2.0}, .name = "bed"};
    const Json json = json_of(whole);
    EXPECT_EQ(json.dump(), R"({"parts":[{"length_m":0.1,"error":null},{"length_m":0.2,"error":0.001}],"interval":[1.0,2.0],"name":"bed"})");
    const auto back = from_json_members<Whole>(json);
    EXPECT_EQ(json_of(back), json);
    // A key that is missing, or holds something else, is named, with the document.
    const auto message = [](const char* text) {
        return test::message_of<UserError>([&] { (void)from_json_members<Whole>(Json::parse(text), "bed.json"); });
    };
    const std::string missing = message(R"({"parts":[{"length_m":0.1,"error":null},{"error":null}],"interval":[1,2],"name":"bed"})");
    EXPECT_TRUE(test::has(missing, "the key `parts[1].length_m` is missing") && test::has(missing, "bed.json")) << missing;
    const std::string other = message(R"({"parts":[{"length_m":"long","error":null}],"interval":[1,2],"name":"bed"})");
    EXPECT_TRUE(test::has(other, "`parts[0].length_m` is \"long\"")) << other;
    EXPECT_TRUE(test::has(message(R"({"parts":[],"interval":[1],"name":"bed"})"), "`interval` is [1]"));

    // Keys that may be absent.
    EXPECT_EQ(json_of(Flattened{}).dump(), R"({"counts":{},"unknown":null,"twice":0.0})");
    const Flattened all{.part = Part{0.1, std::nullopt}, .slope = 2.0, .counts = {{"b", 1}, {"a", 2}}};
    const std::string text = json_of(all).dump();
    EXPECT_EQ(text, R"({"length_m":0.1,"error":null,"slope":2.0,"counts":{"b":1,"a":2},"unknown":null,"twice":4.0})");
    const auto again = from_json_members<Flattened>(Json::parse(text));
    EXPECT_EQ(json_of(again).dump(), text);
    EXPECT_EQ(*find(again.counts, "a"), 2);
    EXPECT_EQ(find(again.counts, "c"), nullptr);
    EXPECT_FALSE(from_json_members<Flattened>(Json::parse(R"({"counts":{},"unknown":null})")).part);
}

struct Renamed {
    double wire_m = 1.0;
};
void describe(ConfigVisitor& v, Renamed& c) {
    v.renamed("mesh_wire_m", "wire_m");
    v.number("wire_m", c.wire_m, positive(), "a wire");
}

TEST(Config, ReadsAKeysOldNameWithAWarning) {
    const test::Folder folder;
    std::vector<std::string> lines;
    set_context({.log = [&](LogLevel, std::string_view line) { lines.emplace_back(line); }, .progress = {}, .interrupted = {}});
    const auto read = [&](const std::string& text) {
        Renamed config;
        TomlFile(folder.write("case.toml", text)).read("screen", [&](ConfigVisitor& v) { describe(v, config); });
        return config.wire_m;
    };
    EXPECT_EQ(read("[screen]\nmesh_wire_m = 0.5\n"), 0.5);
    EXPECT_TRUE(has(lines.at(0), "line 2: `screen.mesh_wire_m` is now called `wire_m`"));
    EXPECT_THROW((void)read("[screen]\nmesh_wire_m = 0.5\nwire_m = 0.4\n"), UserError);
    set_context({});
}

TEST(Config, ReadsAKeyFromItsOldTableWithAWarning) {
    const test::Folder folder;
    const std::string start =
        "[shape]\nkind = \"sphere\"\ndiameter_m = 0.01\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.1\nheight_m = 0.2\n";
    std::vector<std::string> lines;
    set_context({.log = [&](LogLevel, std::string_view line) { lines.emplace_back(line); }, .progress = {}, .interrupted = {}});
    const auto ends_of = [&](const std::string& text) {
        folder.write("case.toml", start + text);
        return stages::read_case(folder.path()).settings.section.ends;
    };
    EXPECT_EQ(ends_of(""), pore_space::Ends::in_situ);
    EXPECT_TRUE(lines.empty());
    EXPECT_EQ(ends_of("[lbm]\nends = \"pressure\"\n"), pore_space::Ends::planes);
    EXPECT_TRUE(has(lines.at(0), "`lbm.ends` is now `section.ends`")) << lines.at(0);
    EXPECT_EQ(ends_of("[lbm]\nends = \"paper\"\n"), pore_space::Ends::paper);
    EXPECT_THROW((void)ends_of("[lbm]\nends = \"paper\"\n[section]\nends = \"planes\"\n"), UserError);
    EXPECT_THROW((void)ends_of("[lbm]\nends = \"planar\"\n"), UserError);
    set_context({});
}

}  // namespace
}  // namespace porepack
