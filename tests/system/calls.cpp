// Calls as the documents show them, and dry runs.
#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <string>
#include <thread>

#include "core/json.hpp"
#include "core/table.hpp"
#include "packing/packing.hpp"
#include "support/cases.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;
using test::small_case;

TEST(Calls, TheOnesThatAreDocumentedWork) {
    const test::Folder folder;
    const auto shape = porepack("shape tetrapod --sphericity 0.53 --volume 7.33e-7 --json");
    ASSERT_EQ(shape.exit_code, 0) << shape.err;
    EXPECT_NEAR(shape.json()["diameter_m"].get<double>(), 4.0293e-3, 1e-6);
    EXPECT_NEAR(shape.json()["convexity"].get<double>(), 0.1988, 2e-4);
    folder.write("grain.toml", "[[capsule]]\na_m = [0, 0, 0]\nb_m = [0, 0, 0]\nradius_m = 0.001\n");
    const auto own = porepack("shape --json --capsules " + quoted(folder.path() / "grain.toml"));
    ASSERT_EQ(own.exit_code, 0) << own.err;
    EXPECT_NEAR(own.json()["sphericity"].get<double>(), 1.0, 1e-6);

    Packing packing{
        .container = parse_container("cylinder:0.03,0.04"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    for (int i = 0; i < 3; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.005 * i - 0.004, 0.002, 0.005 + 0.0101 * i)});
    write_packing(folder.path() / "packing.json", packing);
    const std::string in = quoted(folder.path() / "packing.json");
    for (const std::string& call :
         {"stl " + in, "voxelise " + in + " --voxel-size 1e-3", "slices " + in + " --spacing 5e-4",
          "lbm " + in + " --voxel-size 1e-3 --direction z", "lbm " + quoted(folder.path() / "pore.vti"),
          "lbm " + quoted(folder.path() / "solid.stl") + " --container cylinder:0.03,0.04 --voxel-size 1e-3 --section 0.01,0.02",
          "tortuosity geometric_paper " + in, "tortuosity geometric_paper --dot-pixel 2e-4 " + in,
          "tortuosity shortest_path --voxel-size 1e-3 " + in, "tortuosity shortest_path " + quoted(folder.path() / "pore.vti"),
          "tortuosity diffusive --voxel-size 1e-3 " + in, "tortuosity diffusive " + quoted(folder.path() / "pore.vti"),
          "tortuosity diffusive --dry-run " + in, "tortuosity hydraulic " + quoted(folder.path() / "flow.vti")}) {
        const auto output = porepack(call + " --json");
        EXPECT_EQ(output.exit_code, 0) << call << output.err;
        EXPECT_NO_THROW((void)output.json()) << call;
    }
    for (const char* file :
         {"solid.stl", "stl.manifest.json", "stl.result.json", "pore.vti", "flow.vti", "porosity.csv", "slices/slices.json"})
        EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;
    EXPECT_TRUE(has(porepack("slices " + quoted(folder.path() / "pore.vti")).err, "not of an image"));
    const auto head = porepack(
        "falling-head simulate --permeability 8.931320185e-7 --inertial-permeability 3.873579470e-3 --sample-length 0.12 --start-level 1.6 "
        "--levels 1.3,0.7,0.1 --json");
    ASSERT_EQ(head.exit_code, 0) << head.err;
    EXPECT_NEAR(head.json()["times_s"][2].get<double>(), 3.00825823, 1e-6);
    const auto version = porepack("--version");
    EXPECT_TRUE(has(version.out, "porepack 0."));
    EXPECT_TRUE(has(version.out, "liggghts"));
    for (const char* command : {"run", "status", "shape", "pack", "stl", "voxelise", "slices", "lbm", "foam", "tortuosity",
                                "falling-head simulate", "report", "benchmark"}) {
        const std::string help = porepack(std::string(command) + " --help").out;
        EXPECT_TRUE(has(help, "Example:")) << command;
        EXPECT_TRUE(command == std::string("benchmark") || !has(help, "TEXT")) << command;  // every flag shows its type
    }
    const std::string help = porepack("lbm --help").out;
    for (const char* type : {"--voxel-size number [m]", "--section 2 numbers, with commas [m]", "--direction one of x, y, z",
                             "--output path", "--max-steps whole number", "--superficial-velocity number [m/s]"})
        EXPECT_TRUE(has(help, type)) << type;
    EXPECT_TRUE(has(porepack("stl " + in + " --pores=maybe").err, "\"maybe\" is neither true nor false"));
    EXPECT_EQ(porepack("stl " + in + " --section 0.01,0.02 --pores=false").exit_code, 0);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "pores.stl"));
}

TEST(Calls, DryRunsTellMemoryAndTimeAndWriteNothing) {
    const test::Folder folder;
    folder.write("case.toml", small_case);
    const auto output = porepack("run --dry-run --json " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    EXPECT_EQ(output.json()["configuration"]["geometry"]["voxel_size_m"], 1e-3);
    EXPECT_EQ(output.json()["configuration"]["packing"]["time_step_s"], "auto");
    EXPECT_EQ(output.json()["stages"].size(), 12U);
    EXPECT_TRUE(has(output.out, "memory about"));
    EXPECT_TRUE(has(output.json()["expected"].get<std::string>(), "disk about"));  // of all stages
    // The packing of another configuration is not used.
    const auto number = [&](const char* keys) {
        const Json plan = porepack("run --dry-run --json " + quoted(folder.path()) + keys).json();
        for (const Json& stage : plan["stages"])
            if (const std::string text = stage["expected"]; stage["stage"] == "lbm") return std::stod(text.substr(text.find("about ") + 6));
        return 0.0;
    };
    const double before = number("");
    ASSERT_EQ(porepack("pack " + quoted(folder.path())).exit_code, 0);
    EXPECT_NEAR(number("") / before, 1.0, 0.5);  // eight grains: the estimate before the pour is rough
    EXPECT_NE(number(" --output other --set packing.grains=30"), number(""));
    std::filesystem::remove_all(folder.path() / "results");
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "results"));
}

// From the results of a case: k alone, then with inertia, whose flows are those of the result.
TEST(Calls, PressureDropIsThatOfTheResults) {
    const test::Folder folder;
    folder.write("case.toml",
                 "[shape]\nkind = \"sphere\"\ndiameter_m = 0.01\n[container]\nkind = \"box\"\nsize_m = [0.0101, 0.0101, 0.0101]\n"
                 "periodic = [true, true, true]\n[packing]\nengine = \"none\"\nfile = \"given.json\"\n[geometry]\nvoxel_size_m = 8e-4\n");
    Packing packing{.container = make_box({0.0101, 0.0101, 0.0101}, {true, true, true}),
                    .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)},
                    .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.00505, 0.00505, 0.00505)});
    write_packing(folder.path() / "given.json", packing);
    const std::string in = quoted(folder.path()), call = "pressure-drop --json " + in;
    EXPECT_TRUE(has(porepack(call + " --velocity 1e-7").err, "the case has no permeability yet"));
    const auto lbm = porepack("lbm --json " + in);
    ASSERT_EQ(lbm.exit_code, 0) << lbm.err;
    const double k = lbm.json().at("permeability_m2").get<double>(), mu = 1e-3, area = 0.0101 * 0.0101;
    const auto slow = porepack(call + " --velocity 1e-7 --viscosity 1e-3 --density 1000 --length 0.5");
    ASSERT_EQ(slow.exit_code, 0) << slow.err;
    EXPECT_NEAR(slow.json().at("pressure_drop_Pa").get<double>() / (mu * 1e-7 * 0.5 / k), 1.0, 1e-9);
    EXPECT_NEAR(slow.json().at("flow_rate_m3_per_s").get<double>() / (1e-7 * area), 1.0, 1e-9);
    const Json interval = slow.json().at("pressure_drop_interval_Pa");
    EXPECT_LT(interval[0].get<double>(), slow.json().at("pressure_drop_Pa").get<double>());
    EXPECT_GT(interval[1].get<double>(), slow.json().at("pressure_drop_Pa").get<double>());
    const std::string refused = porepack(call + " --velocity 1e-3").err;
    EXPECT_TRUE(has(refused, "has no flows with inertia")) << refused;
    EXPECT_TRUE(has(refused, "porepack forchheimer")) << refused;
    const auto inertia = porepack("forchheimer --json --openfoam false --voxel-size 8e-4 --reynolds 3,6,12 " + in);
    ASSERT_EQ(inertia.exit_code, 0) << inertia.err;
    const Json flow = inertia.json().at("lbm").at("grids").back();
    const double re = flow.at("flows")[1].at("reynolds").get<double>(),
                 ratio = flow.at("creeping_permeability_m2").get<double>() / flow.at("flows")[1].at("permeability_m2").get<double>();
    const double velocity = re * 1e-6 / inertia.json().at("length_m").get<double>();
    const auto fast = porepack(call + fmt::format(" --flow-rate {:.17g} --viscosity 1e-3 --density 1000 --length 0.5", velocity * area));
    ASSERT_EQ(fast.exit_code, 0) << fast.err;
    EXPECT_NEAR(fast.json().at("pressure_drop_Pa").get<double>() / (mu * velocity * 0.5 / k * ratio), 1.0, 1e-6);
    EXPECT_NEAR(fast.json().at("reynolds").get<double>() / re, 1.0, 1e-9);
    EXPECT_TRUE(has(porepack(call + " --velocity 0.1").err, "the flows with inertia end at"));
    EXPECT_TRUE(has(porepack(call + " --velocity 1 --flow-rate 1").err, "one of --flow-rate and --velocity"));
    EXPECT_TRUE(has(porepack(call + " --velocity 1 --viscosity 1").err, "both a viscosity and a density"));
}

}  // namespace
}  // namespace porepack
