// The reverse question: proposals that are poured and solved, and what a goal must be like.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "core/json.hpp"
#include "core/table.hpp"
#include "stages/case.hpp"
#include "support/cases.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

// A small study from which a search begins: beds of eight grains, on one coarse grid.
class DesignOfSmallBeds : public ::testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(folder_.path() / "base");
        folder_.write("base/case.toml", test::small_case +
                                            "[lbm]\nwalls = \"bounce_back\"\ngrids = 1\niteration_tolerance = 0.01\n"
                                            "fields = \"none\"\n[tortuosity]\nshortest_path = false\ndiffusive = false\n");
        folder_.write("study.toml", "base = \"base\"\nup_to = \"lbm\"\n[[axis]]\nkey = \"shape.sphericity\"\nvalues = [0.5, 0.55, 0.6]\n");
        const auto made = porepack("study run " + quoted(folder_.path()));
        ASSERT_EQ(made.exit_code, 0) << made.err;
    }
    [[nodiscard]] test::Output design(const std::string& words, const char* output = "design") const {
        return porepack("design --container cylinder:0.05,0.15 --study " + quoted(folder_.path()) + " --packings 2 --within 1 --output " +
                        quoted(folder_.path() / output) + " " + words);
    }
    [[nodiscard]] Json result(const char* output = "design") const { return read_json(folder_.path() / output / "design.json"); }

    test::Folder folder_;
};

TEST_F(DesignOfSmallBeds, PoursWhatItProposes) {
    const std::string goal = "--permeability 1e-6,1e-5 --shape tetrapod --volume 7.33e-7 --sphericity 0.52,0.58";
    const auto plan = design(goal + " --dry-run --json");
    ASSERT_EQ(plan.exit_code, 0) << plan.err;
    EXPECT_EQ(plan.json()["beds_known"], 3);
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "design"));
    const auto found = design(goal + " --max-proposals 3");
    ASSERT_EQ(found.exit_code, 0) << found.err;
    const Json design_json = result();
    EXPECT_EQ(design_json["verdict"], "hit") << found.out;
    // What it states is what the seeds of its proposal gave.
    const std::size_t n = design_json["proposals"].size();
    const Path proposal = folder_.path() / "design" / ("proposal_" + std::to_string(n));
    const Json seeds = read_json(proposal / "results" / "seeds" / "result.json");
    EXPECT_NEAR(seeds["permeability_mean_m2"].get<double>() / design_json["proposals"][n - 1]["permeability_m2"].get<double>(), 1.0, 1e-12);
    const TextTable table = read_text_table(folder_.path() / "design" / "proposals.csv");
    EXPECT_EQ(table.rows.size(), n);
    EXPECT_GE(std::stod(table.rows.back()[2]), 0.52) << "sphericity";
    EXPECT_TRUE(has(read_text(folder_.path() / "design" / "design.html"), "<svg"));
    // Seeds are not chosen by their result.
    EXPECT_TRUE(has(read_text(proposal / "case.toml"), "seed = 101")) << read_text(proposal / "case.toml");
    // Again: nothing is computed a second time.
    const auto before = std::filesystem::last_write_time(proposal / "results" / "lbm" / "result.json");
    EXPECT_EQ(design(goal).exit_code, 0);
    EXPECT_EQ(std::filesystem::last_write_time(proposal / "results" / "lbm" / "result.json"), before);
    const auto other = design("--permeability 1e-6");
    EXPECT_EQ(other.exit_code, 2);
    EXPECT_TRUE(has(other.err, "another design lies in this folder")) << other.err;
}

// A shape of the user in any size in a wide container: its first bed tells k of all sizes, k ~ length^2.
TEST_F(DesignOfSmallBeds, MagnifiesABedThatIsKnown) {
    std::string arms;
    for (const char* end :
         {"[0.0176, 0.0066, 0.0066]", "[0.0176, -0.0066, -0.0066]", "[0.0044, 0.0066, -0.0066]", "[0.0044, -0.0066, 0.0066]"})
        arms += fmt::format("[[capsule]]\na_m = [0.011, 0, 0]\nb_m = {}\nradius_m = 0.002\n", end);
    folder_.write("own.toml", arms);
    const auto found =
        porepack("design --container cylinder:1,1 --study " + quoted(folder_.path()) + " --shape " + quoted(folder_.path() / "own.toml") +
                 " --permeability 1e-5,1.02e-5 --packings 3 --within 1 --output " + quoted(folder_.path() / "own"));
    ASSERT_EQ(found.exit_code, 0) << found.err;
    EXPECT_EQ(result("own")["verdict"], "hit") << found.out;
    const TextTable table = read_text_table(folder_.path() / "own" / "proposals.csv");
    ASSERT_EQ(table.rows.size(), 2U) << found.out;
    const auto number = [&](std::size_t row, const char* name) {
        const auto column = std::find(table.columns.begin(), table.columns.end(), name) - table.columns.begin();
        return std::stod(table.rows.at(row).at(static_cast<std::size_t>(column)));
    };
    EXPECT_EQ(number(1, "magnified_from"), 1.0);
    EXPECT_NEAR(number(1, "permeability_m2") / number(0, "permeability_m2"),
                std::pow(number(1, "equal_volume_diameter_m") / number(0, "equal_volume_diameter_m"), 2), 1e-6);
    // The container that is poured is 12 grains wide.
    for (const char* name : {"proposal_1", "proposal_2"}) {
        const stages::Case made = stages::read_case(folder_.path() / "own" / name);
        const double volume = shapes::measure(shapes::make_shape(made.settings.shape)).volume_m3;
        EXPECT_NEAR(made.settings.container.diameter_m / std::cbrt(6.0 * volume / std::numbers::pi), 12.0, 1e-3);
    }
}

TEST_F(DesignOfSmallBeds, SaysWhatIsOutOfReach) {
    const auto far = design("--permeability 1e-12 --shape tetrapod --volume 7.33e-7 --sphericity 0.5,0.6", "far");
    ASSERT_EQ(far.exit_code, 0) << far.err;
    EXPECT_EQ(result("far")["verdict"], "out_of_reach") << far.out;
    EXPECT_LE(result("far")["proposals"].size(), 3U);
    EXPECT_TRUE(has(far.out, "Out of reach. Nearest: tetrapod")) << far.out;
    EXPECT_TRUE(has(far.out, "expected to have k from")) << far.out;
}

TEST(BadDesigns, EachHasItsMessage) {
    const auto fault = [](const std::string& words, const std::string& message) {
        const auto output = porepack("design --container cylinder:0.1,0.4 --dry-run " + words);
        EXPECT_EQ(output.exit_code, 2) << words;
        EXPECT_TRUE(has(output.err, message)) << words << output.err;
    };
    const std::string k = "--permeability 2e-7 ";
    fault("--permeability -1", "the permeability is not a positive value");
    fault("--permeability 2e-7,1e-7", "the permeability is not a positive value");
    fault("--permeability 2e-7,", "neither a number nor a range");
    fault(k + "--within nan", "\"nan\" is not a finite number");
    fault(k + "--porosity 40", "the porosity is not a value");
    fault(k + "--shape ring", "\"ring\" is no shape to choose");
    fault(k + "--shape mixture", "no shape to choose");
    fault(k + "--shape nowhere.toml", "nowhere.toml");
    fault(k + "--free radius_m=1,2", "free parameters belong to a shape of your own");
    fault(k + "--volume -1", "the volume is not positive");
    fault(k + "--sphericity 0.1,0.2", "there is no shape to choose from");
    fault(k + "--volume 7.33e-7 --thinnest 1", "no grain meets the limits");
    fault(k + "--study /nowhere", "no such study");
    EXPECT_TRUE(has(porepack("design --container sphere:1 --permeability 1e-7").err, "cylinder"));
}

}  // namespace
}  // namespace porepack
