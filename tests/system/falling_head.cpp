// The falling head from the command line: simulate, analyse, and a whole case with its causes.
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "core/json.hpp"
#include "packing/packing.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

TEST(FallingHeadTool, WhatItSimulatesItAnalyses) {
    const test::Folder folder;
    std::string curves;
    for (const int run : {1, 2, 3}) {
        const std::string output = quoted(folder.path() / std::to_string(run));
        const auto made = porepack(
            "falling-head simulate --permeability 8.931320185e-7 --inertial-permeability 3.873579470e-3 --noise 5e-4 "
            "--mesh-opening 8e-3 --mesh-wire 2e-3 --json --seed " +
            std::to_string(run) + " --output " + output);
        ASSERT_EQ(made.exit_code, 0) << made.err;
        const Json times = made.json().at("times_s");
        EXPECT_NEAR(times[0].get<double>(), 0.42727431, 1e-6);
        EXPECT_NEAR(times[1].get<double>(), 1.44786669, 1e-6);
        EXPECT_NEAR(times[2].get<double>(), 3.00825823, 1e-6);
        EXPECT_GT(made.json().at("times_full_equation_s")[0].get<double>(), 0.45);
        EXPECT_TRUE(has(read_text(folder.path() / std::to_string(run) / "falling_head.csv"), "# synthetic"));
        curves += " " + quoted(folder.path() / std::to_string(run) / "falling_head.csv");
    }
    const auto found = porepack("falling-head analyse" + curves + " --mesh-opening 8e-3 --mesh-wire 2e-3 --json --output " +
                                quoted(folder.path() / "analysis"));
    ASSERT_EQ(found.exit_code, 0) << found.err;
    const Json fit = found.json().at("packings")[0].at("least_squares");
    const auto interval = fit.at("inverse_permeability_interval_per_m2").get<std::array<double, 2>>();
    EXPECT_LE(interval[0], 1.0 / 8.931320185e-7);
    EXPECT_GE(interval[1], 1.0 / 8.931320185e-7);
    EXPECT_NEAR(fit.at("inertial_permeability_m").get<double>() / 3.873579470e-3, 1.0, 0.02);
    EXPECT_EQ(found.json().at("curves").size(), 3U);
    const Json one = found.json().at("scatter");
    for (const char* inverse : {"inverse_permeability_per_m2", "inverse_inertial_permeability_per_m"}) {
        EXPECT_GT(one.at(inverse).at("within_packings").get<double>(), 0.0) << inverse;
        EXPECT_TRUE(one.at(inverse).at("between_packings").is_null()) << inverse;
    }
    // A fourth test, of another packing.
    ASSERT_EQ(porepack("falling-head simulate --permeability 9e-7 --inertial-permeability 4e-3 --noise 5e-4 --seed 4 --output " +
                       quoted(folder.path() / "4"))
                  .exit_code,
              0);
    const auto fourth = folder.write("fourth.csv", "# packing: B\n" + read_text(folder.path() / "4" / "falling_head.csv"));
    const auto two = porepack("falling-head analyse" + curves + " " + quoted(fourth) + " --json --output " + quoted(folder.path() / "two"));
    ASSERT_EQ(two.exit_code, 0) << two.err;
    EXPECT_EQ(two.json().at("packings").size(), 2U);
    EXPECT_GT(two.json().at("scatter").at("inverse_inertial_permeability_per_m").at("between_packings").get<double>(), 0.0);
    for (const char* file : {"analysis.csv", "falling-head-analysis.result.json", "falling-head-analysis.manifest.json"})
        EXPECT_TRUE(std::filesystem::exists(folder.path() / "analysis" / file)) << file;
    EXPECT_TRUE(!find_program("gnuplot") || std::filesystem::exists(folder.path() / "analysis" / "analysis.svg"));
}

TEST(FallingHeadTool, BadCurvesEndWithTwoAndLeaveNothing) {
    const test::Folder folder;
    const auto analyse = [&](const std::string& text, const std::string& more = "") {
        return porepack("falling-head analyse " + quoted(folder.write("curve.csv", text)) + " --output " + quoted(folder.path() / "out") +
                        " " + more);
    };
    for (const auto& [text, part] :
         {std::pair("t,h\n0,1\n", "does not name a time and a level"),
          std::pair("time_s,level_m\n0,0.2\n1,0.3\n2,0.4\n3,0.5\n4,0.6\n", "does not fall"),
          std::pair("time_s,level_m\n0,1\n1,nan\n", "is no number"), std::pair("time_s,level_m\n0,1\n0,0.9\n", "does not follow"),
          std::pair("time_s,level_mm\n0,900\n1,500\n", "too few"), std::pair("", "no numbers")}) {
        const auto output = analyse(text);
        EXPECT_EQ(output.exit_code, 2) << text;
        EXPECT_TRUE(has(output.err, part));
        EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
    }
    const auto window = analyse("time_s,level_m\n0,1\n1,0.9\n2,0.8\n3,0.7\n4,0.6\n5,0.5\n", "--window 3,4");
    EXPECT_EQ(window.exit_code, 2);
    EXPECT_TRUE(has(window.err, "no level lies in the window 3 to 4 m"));
    const std::string curve = " " + quoted(folder.write("once.csv", "time_s,level_m\n0,1\n1,0.9\n2,0.8\n3,0.7\n4,0.6\n5,0.5\n"));
    const auto twice = porepack("falling-head analyse" + curve + curve + " --output " + quoted(folder.path() / "out"));
    EXPECT_EQ(twice.exit_code, 2);
    EXPECT_TRUE(has(twice.err, "the same levels twice"));
    EXPECT_EQ(porepack("falling-head analyse /nowhere.csv").exit_code, 2);
    EXPECT_EQ(porepack("falling-head analyse").exit_code, 2);
    const auto wires = porepack("falling-head simulate --permeability 1e-7 --mesh-wire 1e-3");
    EXPECT_EQ(wires.exit_code, 2);
    EXPECT_TRUE(has(wires.err, "wires but no openings"));
}

TEST(FallingHeadTool, ACaseTellsItsCauses) {
    const test::Folder folder;
    Packing packing{
        .container = parse_container("cylinder:0.008,0.03"), .shapes = {make_preset(ShapeKind::sphere, 0.002, 0.0)}, .bodies = {}};
    for (int layer = 0; layer < 8; ++layer)
        for (int i = 0; i < 6; ++i)
            packing.bodies.push_back({.shape = 0,
                                      .position_m = Vec3(0.00225 * std::cos(1.0472 * i + 0.5 * layer),
                                                         0.00225 * std::sin(1.0472 * i + 0.5 * layer), 0.00105 + 0.00205 * layer)});
    write_packing(folder.path() / "bed.json", packing);
    folder.write("case.toml",
                 "[shape]\nkind = \"sphere\"\ndiameter_m = 0.002\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.008\nheight_m = 0.03\n"
                 "[packing]\nengine = \"none\"\nfile = \"bed.json\"\n[geometry]\nsection_m = [0.004, 0.013]\nvoxel_size_m = 2.5e-4\n"
                 "[lbm]\ngrids = 1\n[openfoam]\nenabled = false\n"
                 "[forchheimer]\nenabled = true\nopenfoam = false\ngrids = 1\nvoxel_size_m = 3e-4\nreynolds = [2, 5, 10]\n"
                 "[falling_head]\nsample_length_m = 0.015\nscreen_opening_m = 3e-3\ncauses = true\ncomputed_over_measured = 2.0\n"
                 "[tortuosity]\nshortest_path = false\ndiffusive = false\n[report]\npictures = false\n");
    const auto run = porepack("run " + quoted(folder.path()));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(test::schema_faults(folder.path() / "results"), "");
    const Json head = read_json(folder.path() / "results" / "falling-head" / "result.json");
    const Json inertia = read_json(folder.path() / "results" / "forchheimer" / "result.json");
    EXPECT_EQ(head.at("inertial_permeability_m"), inertia.at("inertial_permeability_m"));
    EXPECT_EQ(inertia.at("lbm").at("grids")[0].at("flows").size(), 3U);
    const Json causes = read_json(folder.path() / "results" / "causes" / "result.json");
    std::map<std::string, Json> factors;
    for (const Json& cause : causes.at("causes")) factors[cause.at("cause")] = cause.at("factors");
    EXPECT_GT(factors.size(), 15U);
    EXPECT_GT(causes.at("darcy_alone").get<double>(), 1.0);
    // If the true level is higher than the reading, the water flows faster than the assumed head can drive it.
    EXPECT_GT(factors.at("zero of the level")[0].get<double>(), 1.0);
    const Json& above = factors.at("zero of the level")[1];
    EXPECT_TRUE(above.is_null() || above.get<double>() < 1.0) << above;
    EXPECT_EQ(causes.at("joint").size(), 4U);
    for (const Json& joint : causes.at("joint")) {
        EXPECT_GT(joint.at("draws").get<int>(), 1000);
        EXPECT_GE(joint.at("without_k").get<double>(), 0.0);
        EXPECT_LE(joint.at("reaches").get<double>() + joint.at("without_k").get<double>(), 1.0 + 1e-9);
    }
    // A sample like the paper's, twice: both factors, alone and together. (Few draws of the small bed have a k.)
    Json tetrapods = causes;
    tetrapods["sample"]["permeability_m2"] = 6.26e-7;
    tetrapods["sample"]["inertial_permeability_m"] = 4.4e-3;
    tetrapods["apparatus"]["sample_length_m"] = 0.12;
    write_json(folder.path() / "tetrapods.json", tetrapods);
    const auto both = porepack("falling-head common-causes " + quoted(folder.path() / "tetrapods.json") + " " +
                               quoted(folder.path() / "tetrapods.json") + " --factors 2.8,2.8 --output " + quoted(folder.path() / "both"));
    ASSERT_EQ(both.exit_code, 0) << both.err;
    const Json pairs = read_json(folder.path() / "both" / "common-causes.result.json").at("pairs");
    ASSERT_EQ(pairs.size(), 3U);
    EXPECT_GT(pairs[0].at("correlation").get<double>(), 0.3);
    EXPECT_LT(pairs[0].at("reach_both").get<double>(), pairs[0].at("reach")[0].get<double>());
    EXPECT_GT(pairs[0].at("reach_both").get<double>(), pairs[0].at("reach")[0].get<double>() * pairs[0].at("reach")[1].get<double>());
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "both" / "common_causes.csv"));
    folder.write("no_causes.json", "{}");
    const auto wrong = porepack("falling-head common-causes " + quoted(folder.path()) + " " + quoted(folder.path() / "no_causes.json"));
    EXPECT_EQ(wrong.exit_code, 2);
    EXPECT_TRUE(has(wrong.err, "no result of the causes")) << wrong.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "results" / "stl"));  // no stage needs a surface
    EXPECT_LT(causes.at("computation").at("paper_scheme_over_porepack").get<double>(), 1.0);
    const std::string report = read_text(folder.path() / "results" / "report.md");
    EXPECT_TRUE(has(report, "Measured against computed"));
    EXPECT_TRUE(has(report, "Flow with inertia"));
}

// Both solvers on one packing, up to the Re at which inertia halves the permeability.
TEST(ForchheimerLong, BothSolversAgree) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    folder.write(
        "case.toml",
        "[shape]\nkind = \"tetrapod\"\nsphericity = 0.53\nvolume_m3 = 7.33e-7\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.05\n"
        "height_m = 0.3\n[packing]\ngrains = 60\nseed = 5\nbatch_grains = 2\n[geometry]\nsection_m = [0.03, 0.06]\n"
        "[forchheimer]\nenabled = true\nreynolds = [2, 5, 10, 20, 40]\nvoxel_size_m = 6e-4\ncell_size_m = 1.3e-3\nprocesses = 2\n");
    const auto run = porepack("forchheimer --json " + quoted(folder.path()));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(test::schema_faults(folder.path() / "results"), "");
    const Json result = run.json();
    const Json &lattice = result.at("lbm"), &foam = result.at("openfoam");
    EXPECT_NEAR(foam.at("creeping_permeability_m2").get<double>() / lattice.at("creeping_permeability_m2").get<double>(), 1.0, 0.2);
    EXPECT_NEAR(foam.at("inertial_permeability_m").get<double>() / lattice.at("inertial_permeability_m").get<double>(), 1.0, 0.15);
    EXPECT_EQ(foam.at("flows").size(), 6U);
    // Ergun with the diameter of the sphere of the same specific surface: sphericity times the equal-volume diameter (11.187 mm).
    const double pores = result.at("porosity").get<double>();
    EXPECT_NEAR(result.at("ergun_inertial_permeability_m").get<double>() / (std::pow(pores, 3) * 0.53 * 0.011187 / (1.75 * (1.0 - pores))),
                1.0, 1e-3);
}

}  // namespace
}  // namespace porepack
