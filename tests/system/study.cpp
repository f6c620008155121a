// Studies: points, rows, failures, several runners, figures, Snakemake.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/json.hpp"
#include "core/table.hpp"
#include "study/study.hpp"
#include "support/cases.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

const std::string base_case =
    test::small_case + "[lbm]\nwalls = \"bounce_back\"\ngrids = 1\niteration_tolerance = 0.01\nfields = \"none\"\n";

// Eight tetrapods of 0.87 lie lower than the section: that point fails.
const std::string three_points = R"toml(
base = "base"
up_to = "lbm"
[[axis]]
key = "shape.kind"
values = ["tetrapod", "dolos"]
[[axis]]
key = "shape.sphericity"
from = 0.53
to = 0.87
number = 2
[[leave_out]]
where = { shape.kind = "dolos", shape.sphericity = 0.87 }
[[figure]]
name = "k"
x = "sphericity"
y = "permeability_m2"
by = "shape"
logarithmic = true
curves = [{ title = "Eq. 22", formula = "5.3e-9*exp(7.3*x)" }]
marks = [{ title = "measured", x = 0.6, y = 1e-6 }]
)toml";

class StudyOfThree : public ::testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(study() / "base");
        folder_.write("study/base/case.toml", base_case);
        folder_.write("study/study.toml", three_points);
    }
    [[nodiscard]] Path study() const { return folder_.path() / "study"; }
    [[nodiscard]] test::Output call(const std::string& words) const { return porepack("study " + words + " " + quoted(study())); }
    // "point current" of each row.
    [[nodiscard]] std::vector<std::string> rows() const {
        std::vector<std::string> list;
        for (const auto& row : read_text_table(study() / "study.csv").rows) list.push_back(row[0] + " " + row[1]);
        return list;
    }
    [[nodiscard]] std::string state_of(const std::string& point) const {
        for (const Json& entry : call("status --json").json())
            if (entry["point"] == point) return entry["state"];
        return "unknown";
    }

    test::Folder folder_;
};

TEST_F(StudyOfThree, KeepsItsRowsAndItsFailures) {
    const auto plan = call("run --dry-run --json");
    ASSERT_EQ(plan.exit_code, 0) << plan.err;
    EXPECT_EQ(plan.json()["points"].size(), 3U);
    EXPECT_FALSE(std::filesystem::exists(study() / "points"));
    const auto first = call("run");
    EXPECT_EQ(first.exit_code, 3) << first.err;
    EXPECT_TRUE(has(first.err, "1 of 3 points failed; the first, tetrapod_0.87: the section from 0.004 to 0.016 m is not in the bed"))
        << first.err;
    EXPECT_EQ(rows(), (std::vector<std::string>{"tetrapod_0.53 yes", "dolos_0.53 yes"}));
    EXPECT_EQ(state_of("tetrapod_0.87"), "failed");
    // Each point is a case, and its row says what the case computed.
    const TextTable table = read_text_table(study() / "study.csv");
    const auto column = std::find(table.columns.begin(), table.columns.end(), "permeability_m2") - table.columns.begin();
    const Json lbm = read_json(study() / "points" / "dolos_0.53" / "results" / "lbm" / "result.json");
    EXPECT_NEAR(std::stod(table.rows[1][static_cast<std::size_t>(column)]) / lbm["permeability_m2"].get<double>(), 1.0, 1e-8);
    EXPECT_TRUE(has(porepack("run --up-to lbm " + quoted(study() / "points" / "dolos_0.53")).err, "lbm: already done"));
    // The rows are enough: on another machine nothing is computed again.
    std::filesystem::remove_all(study() / "points");
    const auto again = call("run --points dolos_0.53,1");
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(has(again.out, "2 points: 0 done now, 2 before")) << again.out;
    // Figures, one by hand and those of study.toml.
    EXPECT_EQ(call("plot --x shape.sphericity --y porosity").exit_code, 0);
    EXPECT_EQ(call("plot").exit_code, 0);
    const std::string page = read_text(study() / "study.html");
    EXPECT_TRUE(has(page, "dolos_0.53") && has(page, "<svg") && has(page, "tetrapod_0.87 is missing"));
    EXPECT_TRUE(has(call("plot --x shape --y porosity").err, "is not a column of numbers"));
    EXPECT_TRUE(has(call("plot --x sphericity --y speed").err, "no column `speed`"));
    // Other settings: the rows of the old ones stay, marked.
    folder_.write("study/base/case.toml", base_case + "[tortuosity]\ndiffusive = false\n");
    EXPECT_EQ(state_of("dolos_0.53"), "done") << "lbm does not depend on it";
    std::string text = base_case;
    text.replace(text.find("iteration_tolerance = 0.01"), 26, "iteration_tolerance = 0.02");
    folder_.write("study/base/case.toml", text);
    EXPECT_EQ(state_of("dolos_0.53"), "stale");
    // Old rows are drawn on request only.
    const std::string old = call("plot --x shape.sphericity --y porosity").err;
    EXPECT_TRUE(has(old, "none of the 2 rows of study.csv is of these settings") && has(old, "plot --stale")) << old;
    EXPECT_EQ(call("plot --stale --x shape.sphericity --y porosity --name old").exit_code, 0);
    EXPECT_TRUE(has(read_text(study() / "figures" / "old.dat"), "0.53"));
    EXPECT_EQ(call("run --points 3").exit_code, 0);
    EXPECT_EQ(rows(), (std::vector<std::string>{"dolos_0.53 yes", "tetrapod_0.53 no", "dolos_0.53 no"}));
}

TEST_F(StudyOfThree, TwoRunnersShareThePoints) {
    std::string text = three_points;
    text.replace(text.find("number = 2"), 10, "number = 1");
    folder_.write("study/study.toml", text);
    const auto json = [&](const char* name) { return read_json(folder_.path() / name); };
    const std::string words =
        quoted(POREPACK_PROGRAM) + " study run --threads 1 --json " + quoted(study()) + " > " + quoted(folder_.path());
    const std::string both = words + "/one.json & " + words + "/two.json; wait";
    ASSERT_EQ(std::system(("bash -c " + quoted(both) + " 2> /dev/null").c_str()), 0);
    EXPECT_EQ(json("one.json")["done"].size() + json("two.json")["done"].size(), 2U) << json("one.json") << json("two.json");
    EXPECT_EQ(rows(), (std::vector<std::string>{"tetrapod_0.53 yes", "dolos_0.53 yes"}));
    // Snakemake finds the points done, and draws the figures.
    ASSERT_EQ(call("export --snakemake").exit_code, 0);
    if (!find_program("snakemake")) GTEST_SKIP() << "snakemake is not installed";  // no package of the lists
    const Path program(POREPACK_PROGRAM);
    const std::string run =
        "cd " + quoted(study()) + " && PATH=" + quoted(program.parent_path()) + ":\"$PATH\" snakemake -j2 > snakemake.log 2>&1";
    EXPECT_EQ(std::system(run.c_str()), 0) << read_text(study() / "snakemake.log");
    EXPECT_TRUE(std::filesystem::exists(study() / "study.html"));
    EXPECT_TRUE(std::filesystem::exists(study() / "points" / "dolos_0.53.done"));
}

TEST(BadStudies, EachHasItsMessage) {
    const test::Folder folder;
    std::filesystem::create_directories(folder.path() / "base");
    folder.write("base/case.toml", base_case);
    const auto fault = [&](const std::string& text, const std::string& message) {
        folder.write("study.toml", text);
        const auto output = porepack("study status " + quoted(folder.path()));
        EXPECT_EQ(output.exit_code, 2) << text;
        EXPECT_TRUE(has(output.err, message)) << text << output.err;
    };
    const std::string head = "base = \"base\"\n[[axis]]\n", axis = "key = \"shape.sphericity\"\n";
    fault("base = \"base\"\n", "the study has no axis");
    fault("bass = \"base\"\n", "perhaps [base]");
    fault("base = \"nowhere\"\n[[axis]]\n" + axis + "values = [0.5]\n", "no such case");
    fault(head + "key = \"sphericity\"\nvalues = [0.5]\n", "`key` is not the name of a key");
    fault(head + "key = \"shape.spericity\"\nvalues = [0.5]\n", "unknown key `shape.spericity`");
    fault(head + axis + "values = [5]\n", "where:   --set shape.sphericity");
    fault(head + axis, "`values` is missing");
    fault(head + axis + "values = []\n", "not a list of values");
    fault(head + axis + "values = [0.5]\nnumber = 2\n", "exclude each other");
    fault(head + axis + "from = 0\nto = 1\nnumber = 2\nspacing = \"logarithmic\"\n", "needs positive ends");
    fault(head + "key = [\"packing.seed\", \"shape.sphericity\"]\nvalues = [[1, 0.5], [2]]\n", "a list of 2 values");
    fault(head + axis + "values = [0.5, 0.5]\n", "two points have the name 0.5");
    fault(head + axis + "values = [0.5]\n[[axis]]\n" + axis + "values = [0.6]\n", "two axes have the key");
    fault(head + axis + "values = [0.5]\n[[leave_out]]\nwhere = { packing.seed = 1 }\n", "no axis has the key `packing.seed`");
    fault(head + axis + "values = [0.5]\n[[leave_out]]\nwhere = { shape.sphericity = 0.5 }\n", "has no points");
    fault("up_to = \"lbn\"\n" + head + axis + "values = [0.5]\n", "no stage lbn");
    folder.write("study.toml", head + axis + "values = [0.5]\n[[figure]]\nname = \"k\"\nx = \"porosity\"\ny = \"porosity\"\n");
    const auto run = [&](const std::string& words) { return porepack("study " + words + " " + quoted(folder.path())).err; };
    EXPECT_TRUE(has(run("run --points 2"), "the study has no point \"2\""));
    EXPECT_TRUE(has(run("run --points 0.6"), "perhaps `0.5`"));
    EXPECT_TRUE(has(run("plot"), "no point of the study is done"));
    EXPECT_TRUE(has(run("plot --x porosity"), "needs --x and --y"));
    folder.write("study.toml", head + "key = \"report.title\"\nvalues = [\"..\"]\n");
    EXPECT_TRUE(has(porepack("study status " + quoted(folder.path())).out, "_.."));
    folder.write("study.toml", head + axis + "values = [0.5]\n");
    folder.write("study.csv", "point,porosity\na,1,2\n");
    EXPECT_TRUE(has(run("status"), "3 fields, but the header has 2"));
    folder.write("study.csv", "point,porosity\na,1\n");
    EXPECT_TRUE(has(run("status"), "the column `digest` is missing"));
}

// Formulas reach gnuplot, which can run commands.
TEST(BadStudies, FormulasAreArithmetic) {
    const test::Folder folder;
    std::filesystem::create_directories(folder.path() / "base");
    folder.write("base/case.toml", base_case);
    const std::string text =
        "base = \"base\"\nup_to = \"shape\"\n[[axis]]\nkey = \"shape.sphericity\"\nvalues = [0.53, 0.6]\n"
        "[[figure]]\nname = \"omega\"\nx = \"sphericity\"\ny = \"convexity\"\ncurves = [{ title = \"a\", formula = FORMULA }]\n";
    for (const auto& [formula, right] : {std::pair("'1e-2*exp(-7.3*x)/(1+x**2)'", true),
                                         {"'system(\"id\")'", false},
                                         {"'`id`'", false},
                                         {"'x; print 1'", false},
                                         {"'exec(x)'", false}}) {
        folder.write("study.toml", std::string(text).replace(text.find("FORMULA"), 7, formula));
        ASSERT_EQ(porepack("study run " + quoted(folder.path())).exit_code, 0);
        const auto output = porepack("study plot " + quoted(folder.path()));
        EXPECT_EQ(output.exit_code, right ? 0 : 2) << formula << output.err;
    }
}

// Before anything runs: what the time limits cut off, stages that are not run, and axes without effect.
TEST(StudyPlans, SayWhatIsLeftOut) {
    const test::Folder folder;
    folder.write("case.toml", test::small_case + "[packings]\nuntil_sure = 0.05\nmax_time_s = 1\n");
    const auto plan = [&](const std::string& up_to, const std::string& key, const std::string& more) {
        folder.write("study.toml", "up_to = \"" + up_to + "\"\n[[axis]]\nkey = \"" + key + "\"\nvalues = [0.2, 0.3]\n");
        return porepack("study run --dry-run " + more + " " + quoted(folder.path()));
    };
    const auto with_limit = plan("lbm", "packing.friction", "--max-time 0.1");
    EXPECT_TRUE(has(with_limit.out, "no point begins after 0.1 s (--max-time)")) << with_limit.out;
    EXPECT_TRUE(has(with_limit.out, "not run, by up_to = \"lbm\": ")) << with_limit.out;
    EXPECT_FALSE(has(with_limit.err, "the same computation")) << with_limit.err;
    const auto without_effect = plan("pack", "tortuosity.dot_spacing_m", "");
    EXPECT_TRUE(has(without_effect.err,
                    "0.2 and 0.3 are the same computation: tortuosity.dot_spacing_m changes nothing up to the "
                    "stage pack"))
        << without_effect.err;
    const auto limited = porepack("run --dry-run " + quoted(folder.path()));
    EXPECT_TRUE(has(limited.out + limited.err, "(max_time_s)")) << limited.out << limited.err;
}

// A point lies deeper than its case: files that the case names are named from there.
TEST(StudyPoints, FindTheFilesOfTheirCase) {
    const test::Folder folder;
    folder.write("scan.raw", "12345678");
    folder.write("case.toml",
                 "[image]\nfile = \"scan.raw\"\ndims = [2, 2, 2]\ntype = \"uint8\"\nvoxel_size_m = [1e-3]\nthreshold = 52.0\nwalls = "
                 "\"half_way\"\n");
    folder.write("study.toml", "up_to = \"lbm\"\n[[axis]]\nkey = \"image.threshold\"\nvalues = [52.0, 53.0]\n");
    const Study study = read_study(folder.path());
    for (const Point& point : study.points) {
        const Case made = write_point(study, point);
        EXPECT_TRUE(std::filesystem::equivalent(made.resolve(made.settings.image.file), folder.path() / "scan.raw")) << point.name;
    }
}

}  // namespace
}  // namespace porepack
