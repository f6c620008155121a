// Lattice Boltzmann and OpenFOAM on the same packing.
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "core/json.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

TEST(CrossCheck, BothSolversAgreeWithinTheirIntervals) {
    REQUIRE_PROGRAM("liggghts");
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const Path source = Path(POREPACK_SOURCE_FOLDER) / "cases" / "cross_check";
    // A smaller bed on coarser grids.
    std::string text = read_text(source / "case.toml");
    for (const auto& [fine, coarse] : {std::pair{"tolerance = 0.02", "tolerance = 0.05"},
                                       {"cell_size_m = 0.00065", "cell_size_m = 0.001"},
                                       {"grains = 20", "grains = 12"},
                                       {"[0.01, 0.026]", "[0.008, 0.016]"},
                                       {"meshes = 3", "meshes = 2"}}) {
        ASSERT_TRUE(has(text, fine));
        text.replace(text.find(fine), std::string(fine).size(), coarse);
    }
    folder.write("case.toml", text);
    const auto output = porepack("benchmark cross-check --json " + quoted(folder.path()) + " --output " + quoted(folder.path() / "out"));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const Json row = output.json().at("cases").at(0);
    std::printf("  OpenFOAM against LBM %+.2f %%, profiles differ by %.1f %% (z) and %.1f %% (r), %.0f times the time\n",
                100.0 * row["openfoam_against_lbm"].get<double>(), 100.0 * row["speed_profile_z_difference"].get<double>(),
                100.0 * row["speed_profile_r_difference"].get<double>(), row["openfoam_time_over_lbm"].get<double>());
    EXPECT_TRUE(row["intervals_overlap"]);
    EXPECT_LT(std::abs(row["openfoam_against_lbm"].get<double>()), 0.03);
    EXPECT_LT(row["speed_profile_z_difference"].get<double>(), 0.06);  // slabs of 1 mm, as high as the cells
    EXPECT_LT(row["speed_profile_r_difference"].get<double>(), 0.08);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / "cross-check.json"));
    // The hydraulic tortuosity by both solvers.
    double hydraulic[2];
    int i = 0;
    for (const Path& flow : {folder.path() / "results" / "lbm" / "flow.vti", folder.path() / "results" / "foam" / "mesh_fine"}) {
        const auto one = porepack("tortuosity hydraulic --json " + quoted(flow) + " --output " + quoted(folder.path() / "hydraulic"));
        ASSERT_EQ(one.exit_code, 0) << one.err;
        hydraulic[i++] = one.json()["tortuosity_hydraulic"].get<double>();
    }
    std::printf("  hydraulic tortuosity %.4f (LBM), %.4f (OpenFOAM)\n", hydraulic[0], hydraulic[1]);
    EXPECT_NEAR(hydraulic[0] / hydraulic[1], 1.0, 0.02);
}

}  // namespace
}  // namespace porepack
