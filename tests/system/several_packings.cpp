// Several packings of a case: their scatter, what one packing does not tell, and as many as the mean needs.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/json.hpp"
#include "core/table.hpp"
#include "support/cases.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;
using test::small_case;

// A case without OpenFOAM and pictures, with the keys of several packings.
std::string case_of_packings(const std::string& packings, const std::string& lbm = {}) {
    std::string text = small_case;
    text.replace(text.find("cell_size_m = 0.002\nmeshes = 1"), 30, "enabled = false");
    return text + "[packings]\n" + packings + "\n[lbm]\nfields = \"none\"\n" + lbm + "[report]\npictures = false\n";
}

// seed -> k of seeds.csv.
std::map<long, double> permeabilities_of_seeds(const Path& results) {
    std::map<long, double> k;
    for (const auto& row : core::read_table(results / "seeds" / "seeds.csv")) k[std::lround(row.at(0))] = row.at(1);
    return k;
}

TEST(SeveralPackings, SeveralSeedsGiveTheScatterBetweenPackings) {
    const test::Folder folder;
    folder.write("case.toml", case_of_packings("seeds = 3"));
    const Path results = folder.path() / "results";
    const auto output = porepack("run --json " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const Json seeds = read_json(results / "seeds" / "result.json");
    EXPECT_EQ(test::schema_faults(results), "");
    EXPECT_EQ(seeds["packings"], 3);
    const std::map<long, double> k = permeabilities_of_seeds(results);
    ASSERT_EQ(k.size(), 3U);
    const double mean = (k.at(1) + k.at(2) + k.at(3)) / 3.0;
    double squares = 0.0;
    for (const auto& [seed, value] : k) squares += (value - mean) * (value - mean);
    const double deviation = std::sqrt(squares / 2.0), numerical = seeds["numerical_half_width_m2"].get<double>();
    EXPECT_NEAR(seeds["permeability_mean_m2"].get<double>() / mean, 1.0, 1e-6);
    EXPECT_NEAR(seeds["standard_deviation_between_packings_m2"].get<double>() / deviation, 1.0, 1e-5);
    EXPECT_NEAR(seeds["standard_error_of_mean_m2"].get<double>() / std::sqrt(squares / 6.0), 1.0, 1e-5);
    EXPECT_GT(numerical, 0.0);
    EXPECT_NEAR(seeds["unseen_share"].get<double>(), 1.0 - std::cbrt(0.05), 1e-12);
    const Json other = read_json(results / "seed_2" / "lbm" / "result.json"), own = read_json(results / "lbm" / "result.json");
    EXPECT_NE(other["permeability_m2"], own["permeability_m2"]);
    EXPECT_FALSE(std::filesystem::exists(results / "lbm" / "flow.vti"));
    // The three statements: t(0.975, 2) = 4.3026527.
    const Json statements = read_json(results / "result.json")["uncertainty"]["permeability_m2"];
    const auto half_width = [&](const char* which) {
        return 0.5 * (statements[which]["interval"][1].get<double>() - statements[which]["interval"][0].get<double>());
    };
    EXPECT_EQ(statements["this_packing"]["value"], own["permeability_m2"]);
    EXPECT_NEAR(half_width("mean_of_such_packings") / std::hypot(4.3026527 * deviation / std::sqrt(3.0), numerical), 1.0, 1e-5);
    EXPECT_NEAR(half_width("next_such_packing") / std::hypot(4.3026527 * deviation * std::sqrt(4.0 / 3.0), numerical), 1.0, 1e-5);
    const Json budget = read_json(results / "uncertainty" / "result.json")["budget_of_permeability"];
    EXPECT_EQ(budget.back()["source"], "packing to packing");
    EXPECT_NEAR(budget.back()["relative_standard_uncertainty"].get<double>() / (deviation / mean), 1.0, 1e-5);
    const std::string report = read_text(results / "report.md");
    EXPECT_TRUE(has(report, "mean of 3 packings"));
    EXPECT_TRUE(has(report, "next such packing (n = 3)"));
    EXPECT_TRUE(has(report, "packings of another kind that make up 63 % of all are absent"));
    EXPECT_TRUE(has(report, "| seeds | ")) << "its cost";
    // Another number of packings leaves the first one as it is. The key's place in version 0.1 is still read.
    std::string text = case_of_packings("");
    text.replace(text.find("grains = 8"), 10, "grains = 8\nseeds = 2");
    folder.write("case.toml", text);
    const auto again = porepack("run " + quoted(folder.path()));
    EXPECT_TRUE(has(again.err, "pack: already done")) << again.err;
    EXPECT_TRUE(has(again.err, "is now `packings.seeds`")) << again.err;
    EXPECT_EQ(permeabilities_of_seeds(results), (std::map<long, double>{{1, k.at(1)}, {2, k.at(2)}}));
}

TEST(SeveralPackings, OnePackingDoesNotTellOfTheNext) {
    const test::Folder folder;
    folder.write("case.toml", case_of_packings("", "walls = \"bounce_back\"\ngrids = 2\n"));
    const auto output =
        porepack("run --set tortuosity.diffusive=false --output " + quoted(folder.path() / "out") + " " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    EXPECT_TRUE(has(output.out, "k, mean of such packings     not known")) << output.out;
    const Json next = read_json(folder.path() / "out" / "result.json")["uncertainty"]["permeability_m2"]["next_such_packing"];
    EXPECT_TRUE(next["value"].is_null());
    EXPECT_TRUE(has(next["why"].get<std::string>(), "not known from one packing"));
}

// A bed that was weighed: its k from the line through the packings, in the report and the summary; and what the packings do not bracket.
TEST(SeveralPackings, TheBedOfMeasuredPorosityHasItsOwnPermeability) {
    const test::Folder folder;
    const std::string quick = "grids = 2\n[tortuosity]\nshortest_path = false\ndiffusive = false\n";
    const auto run = [&](const std::string& measured) {
        folder.write("case.toml", case_of_packings("seeds = 5\n" + measured, quick));
        const auto end = porepack("run --output " + quoted(folder.path() / "out") + " " + quoted(folder.path()));
        EXPECT_EQ(end.exit_code, 0) << end.err;
        EXPECT_EQ(test::schema_faults(folder.path() / "out"), "");
        return end;
    };
    const auto statement = [&] {
        return read_json(folder.path() / "out" / "result.json")["uncertainty"]["permeability_m2"]["bed_of_measured_porosity"];
    };
    run("measured_porosity = [0.85, 0.004]");
    // The same line, computed here.
    std::vector<double> x, y;
    for (const auto& row : core::read_table(folder.path() / "out" / "seeds" / "seeds.csv")) {
        x.push_back(std::log(std::pow(row.at(2), 3.0) / std::pow(1.0 - row.at(2), 2.0)));
        y.push_back(std::log(row.at(1)));
    }
    ASSERT_EQ(x.size(), 5U);
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (std::size_t i = 0; i < 5; ++i) {
        sx += x[i];
        sy += y[i];
        sxx += x[i] * x[i];
        sxy += x[i] * y[i];
    }
    const double slope = (5.0 * sxy - sx * sy) / (5.0 * sxx - sx * sx);
    const double k = std::exp((sy - slope * sx) / 5.0 + slope * std::log(std::pow(0.85, 3.0) / std::pow(0.15, 2.0)));
    const Json bed = statement();
    EXPECT_NEAR(bed["value"].get<double>() / k, 1.0, 1e-6);
    EXPECT_LT(bed["interval"][0].get<double>(), k);
    EXPECT_GT(bed["interval"][1].get<double>(), k);
    EXPECT_EQ(bed["measured_part"], "section");
    EXPECT_TRUE(has(read_text(folder.path() / "out" / "report.md"), "| the bed of measured porosity 0.85 |"));
    // The whole bed, whose porosity is another number; and a value beyond all packings.
    run("measured_porosity = [0.85, 0.004]\nmeasured_part = \"bed\"");
    EXPECT_NE(statement()["value"], bed["value"]);
    const auto beyond = run("measured_porosity = [0.7, 0.004]");
    EXPECT_TRUE(has(beyond.err, "the packings do not bracket it")) << beyond.err;
    EXPECT_TRUE(has(beyond.out, "k, the bed of measured porosity not known")) << beyond.out;
    EXPECT_TRUE(statement()["value"].is_null());
    run("measured_porosity = [0.85, 0.004]\nmeasured_part = \"between\"\nmeasured_between_m = [0.004, 0.14]");
    EXPECT_TRUE(has(statement()["why"].get<std::string>(), "above the top of at least one of the packings"));
}

// Friction that is not known varies between the packings: its effect is a row of the budget, and the packings are spread about the case's.
TEST(SeveralPackings, FrictionThatIsNotKnownIsARowOfTheBudget) {
    const test::Folder folder;
    std::string text = case_of_packings("seeds = 5", "grids = 2\n[tortuosity]\nshortest_path = false\ndiffusive = false\n");
    text.replace(text.find("grains = 8"), 10, "grains = 8\nfriction_uncertainty = 0.1");
    folder.write("case.toml", text);
    const auto end = porepack("run --output " + quoted(folder.path() / "out") + " " + quoted(folder.path()));
    ASSERT_EQ(end.exit_code, 0) << end.err;
    EXPECT_EQ(test::schema_faults(folder.path() / "out"), "");
    std::vector<double> friction;
    for (const auto& row : core::read_table(folder.path() / "out" / "seeds" / "seeds.csv")) friction.push_back(row.at(10));
    const double reach = 0.1 * std::sqrt(3.0);
    const std::vector<double> expected = {0.35, 0.35, 0.35 - reach / 2.0, 0.35 + reach / 2.0, 0.35 - 0.75 * reach};
    ASSERT_EQ(friction.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(friction[i], expected[i], 1e-8);
    const Json member = read_json(folder.path() / "out" / "seed_4" / "pack" / "manifest.json");
    EXPECT_NEAR(member["configuration"]["packing"]["friction"].get<double>(), expected[3], 1e-12);
    bool found = false;
    const Json budget = read_json(folder.path() / "out" / "uncertainty" / "result.json")["budget_of_permeability"];
    for (const Json& row : budget)
        if (row["source"] == "friction") {
            found = true;
            EXPECT_EQ(row["part"], "input");
            EXPECT_EQ(row["evidence"], "measured");
        }
    EXPECT_TRUE(found);
}

// Packings count in the order of their seeds, so that their number and the mean do not depend on what runs at once or was killed.
TEST(SeveralPackings, UntilSureGivesTheSameOnAnyNumberOfThreads) {
    const test::Folder folder;
    folder.write("case.toml", case_of_packings("until_sure = 0.25\nmax_packings = 12\npours_per_flow = 2",
                                               "walls = \"bounce_back\"\ngrids = 2\n[tortuosity]\nshortest_path = false\n"
                                               "diffusive = false\n"));
    const auto run = [&](const char* options, const char* output) {
        const Path results = folder.path() / output;
        const auto end =
            porepack("run --up-to seeds " + std::string(options) + " --output " + quoted(results) + " " + quoted(folder.path()));
        EXPECT_EQ(end.exit_code, 0) << end.err;
        return read_json(results / "seeds" / "result.json");
    };
    const Json one = run("--threads 1", "one");
    EXPECT_TRUE(one["sure"]) << one;
    EXPECT_GE(one["packings"], 6);
    EXPECT_EQ(one["pours"]["packings"], 2 * one["packings"].get<long>());
    EXPECT_EQ(one["quantities"]["porosity"]["packings"], one["pours"]["packings"]);
    EXPECT_LE(one["relative_half_width"], 0.25);
    EXPECT_TRUE(one["stopped_by"].is_null());
    // Killed while several packings are under way, then run again.
    const Path script = folder.write("kill.sh",
                                     "\"$1\" run --up-to seeds --threads 2 --output \"$3\" \"$2\" & pid=$!\n"
                                     "for i in $(seq 600); do [ -e \"$3/seed_3/log.porepack\" ] && break; sleep 0.05; done\n"
                                     "kill -9 $pid; wait $pid; sleep 0.3; pgrep -f \"$3/seed_\" && echo orphan\n");
    const std::string words = test::quoted(POREPACK_PROGRAM) + " " + quoted(folder.path()) + " " + quoted(folder.path() / "two");
    (void)std::system(("bash " + quoted(script) + " " + words + " > " + quoted(folder.path() / "kill.log") + " 2>/dev/null").c_str());
    EXPECT_EQ(read_text(folder.path() / "kill.log"), "") << "a packing runs on";
    const Json two = run("--threads 2", "two");
    EXPECT_EQ(one["packings"], two["packings"]);
    // Sums over nodes are formed in another order by another number of threads.
    EXPECT_NEAR(one["relative_half_width"].get<double>() / two["relative_half_width"].get<double>(), 1.0, 1e-9);
    for (const char* table : {"seeds.csv", "pours.csv"})
        EXPECT_EQ(read_text(folder.path() / "one" / "seeds" / table), read_text(folder.path() / "two" / "seeds" / table));
    // Fewer packings than it takes, and an interval that no number of packings can reach: the result says what ended it.
    const Json few = run("--until-sure 0.15 --max-packings 5", "one");
    EXPECT_FALSE(few["sure"]);
    EXPECT_EQ(few["stopped_by"], "max_packings");
    EXPECT_EQ(few["packings"], 5);
    EXPECT_EQ(run("--until-sure 0.01", "one")["stopped_by"], "numerical");
}

}  // namespace
}  // namespace porepack
