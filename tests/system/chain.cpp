// The program as a user calls it: the chain on the real engines, in reduced sizes; resuming; reruns.
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include "core/json.hpp"
#include "core/table.hpp"
#include "packing/packing.hpp"
#include "scans/gray_input.hpp"
#include "support/cases.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;
using test::small_case;

std::string with_liggghts(std::string text) {
    return text.replace(text.find("[packing]\n"), 10, "[packing]\nengine = \"liggghts\"\n");
}

// cases/ct with 24 grains in a narrower tube: a scan with the paper's threshold, with walls from gray values, and with fitted poses.
TEST(Chain, ThreeWaysFromAScan) {
    const test::Folder folder;
    const Path cases = Path(POREPACK_SOURCE_FOLDER) / "cases" / "ct";
    const std::string small = " --set container.diameter_m=0.042 --set packing.grains=24 --set geometry.section_m=[0.012,0.03]";
    const auto run = [&](const std::string& way, const std::string& more, const char* last) {
        const auto made =
            porepack("run --json " + quoted(cases / way) + more + " --up-to " + last + " --output " + quoted(folder.path() / way));
        EXPECT_EQ(made.exit_code, 0) << way << made.err;
        return made.exit_code == 0 ? made.json() : Json();
    };
    const Json truth = run("truth", small, "voxelise");
    const std::string scan = quoted(folder.path() / "scan.nrrd");
    ASSERT_EQ(
        porepack("image simulate " + quoted(folder.path() / "truth/pack/packing.json") + " " + scan + " --voxel-size 5e-4 --part 0,0.05")
            .exit_code,
        0);
    const Path segmented = folder.path() / "segmented";
    ASSERT_EQ(
        porepack("image segment " + scan + " --image-find-container --image-threshold 12 --keep-cut-grains --output " + quoted(segmented))
            .exit_code,
        0);
    const std::string part = " --set geometry.section_m=[0.012,0.03] --set ";
    const std::string of_scan = part + quoted("image.file=" + (folder.path() / "scan.nrrd").string());
    const Json threshold = run("threshold", part + quoted("image.file=" + (segmented / "pore.vti").string()), "voxelise"),
               gray = run("gray", of_scan, "voxelise"), fit = run("fit", of_scan, "voxelise");
    const auto porosity = [](const Json& result) { return result.at("porosity").get<double>(); };
    EXPECT_NEAR(porosity(fit), porosity(truth), 0.001);
    EXPECT_NEAR(porosity(gray), porosity(truth), 0.015);
    EXPECT_LT(porosity(threshold), porosity(truth) - 0.02);
    const Json pack = read_json(folder.path() / "fit/pack/result.json");
    EXPECT_EQ(pack.at("engine"), "fit");
    EXPECT_TRUE(pack.at("fit").at("doubts").empty()) << pack.at("fit").at("doubts");
    EXPECT_GT(pack.at("grains").get<int>(), 10);

    const auto refused =
        porepack("run --dry-run " + quoted(cases / "fit") + " --set packing.grains=3 --output " + quoted(folder.path() / "no"));
    EXPECT_EQ(refused.exit_code, 2) << refused.out;
}

TEST(Chain, PoursReadsBackAndRerunsToTheSameBytes) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    folder.write("case.toml", with_liggghts(small_case));
    const auto first = porepack("pack --json " + quoted(folder.path()));
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const Json result = first.json();
    EXPECT_EQ(result["grains"], 8);
    EXPECT_TRUE(result["at_rest"]);
    EXPECT_LT(result["pose_error_relative_to_diameter"].get<double>(), 1e-6);
    EXPECT_LT(result["largest_overlap_relative_to_diameter"].get<double>(), 0.10);
    const Path packing = folder.path() / "results" / "pack" / "packing.json";
    const std::string bytes = read_text(packing);
    std::filesystem::remove_all(folder.path() / "results");
    ASSERT_EQ(porepack("pack " + quoted(folder.path())).exit_code, 0);
    EXPECT_EQ(read_text(packing), bytes);
    const auto by_hand = std::system(("cd " + quoted(folder.path() / "results" / "pack" / "run") +
                                      " && liggghts -in pour.in > by_hand.log 2>&1 && grep -q 'POREPACK done' by_hand.log")
                                         .c_str());
    EXPECT_EQ(by_hand, 0);
}

// Rods have different moments of inertia about their axes; the origin of a dolos is not its centre of mass.
TEST(Chain, PosesOfOtherShapesComeBackToo) {
    REQUIRE_PROGRAM("liggghts");
    for (const std::string kind : {"rod", "dolos", "sphere"}) {
        const test::Folder folder;
        folder.write("case.toml", "[shape]\nkind = \"" + kind + "\"\ndiameter_m = 0.005\n" +
                                      (kind == "sphere" ? "" : "length_m = 0.008\n") +
                                      "[container]\nkind = \"box\"\nsize_m = [0.04, 0.04, 0.1]\n[packing]\nengine = \"liggghts\"\ngrains = "
                                      "4\nhorizontal_speed_m_per_s = 0\n[geometry]\nsection_m = [0.0, 0.005]\n");
        const auto output = porepack("pack --json " + quoted(folder.path()));
        ASSERT_EQ(output.exit_code, 0) << kind << output.err;
        EXPECT_LT(output.json()["pose_error_relative_to_diameter"].get<double>(), 1e-6) << kind;
    }
}

TEST(Chain, AnUnsymmetricUnionKeepsItsFrame) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    folder.write("case.toml", R"(
[shape]
kind = "capsules"
[[shape.capsule]]
a_m = [0, 0, 0]
b_m = [0.009, 0, 0]
radius_m = 0.002
[[shape.capsule]]
a_m = [0, 0, 0]
b_m = [0, 0.006, 0.002]
radius_m = 0.0025
[container]
kind = "cylinder"
diameter_m = 0.05
height_m = 0.1
[packing]
engine = "liggghts"
grains = 5
[geometry]
section_m = [0.0, 0.004]
)");
    const auto output = porepack("pack --json " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    EXPECT_LT(output.json()["pose_error_relative_to_diameter"].get<double>(), 1e-6);
    // The capsules of the packing rest on the floor: the exact body, not only its clump, is at the right position.
    const Packing packing = read_packing(folder.path() / "results" / "pack" / "packing.json");
    const Overlaps overlaps = find_overlaps(packing);
    EXPECT_LT(overlaps.largest_with_wall_m, 0.05 * 0.004);
}

TEST(Schemas, AreChecked) {
    REQUIRE_INSTALLED(test::has_schema_validator(), "python3-jsonschema, which compares results with docs/schema,");
    const test::Folder folder;
    folder.write("results/lbm/manifest.json", "{}");
    folder.write("results/lbm/result.json",
                 R"({"permeability_m2": 1e-9, "permeability_interval_m2": null, "converged": true, "colour": 1})");
    const std::string faults = test::schema_faults(folder.path() / "results");
    EXPECT_TRUE(has(faults, "'colour' was unexpected"));
    EXPECT_TRUE(has(faults, "'stage' is a required property"));
}

TEST(Chain, TheQuickstartInReducedSize) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    folder.write("case.toml", small_case);
    const auto output = porepack("run --json " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const Path results = folder.path() / "results";
    for (const char* file :
         {"report.html", "report.md", "result.json", "stl/solid.stl", "voxelise/pore.vti", "lbm/flow.vti", "slices/slice_0000.png",
          "pack/manifest.json", "report/along_z.svg", "voxelise/porosity.csv", "foam/mesh_fine/case.foam", "falling-head/falling_head.csv"})
        EXPECT_TRUE(std::filesystem::exists(results / file)) << file;
    EXPECT_EQ(test::schema_faults(results), "");
    const Json result = output.json();
    const auto both =
        porepack("compare --json " + quoted(folder.path()) + " " + quoted(results) + " --output " + quoted(folder.path() / "both"));
    ASSERT_EQ(both.exit_code, 0) << both.err;
    const Json compared = both.json();
    for (const Json& row : compared.at("quantities")) EXPECT_EQ(row.at("values").at(0), row.at("values").at(1)) << row.dump();
    EXPECT_EQ(compared.at("quantities").at(0).at("values").at(0).at("value"), result["quantities"].at(0).at("value"));
    EXPECT_TRUE(has(read_text(folder.path() / "both" / "compare.csv"), "permeability_lbm,m2"));
    EXPECT_TRUE(!find_program("gnuplot") || std::filesystem::exists(folder.path() / "both" / "compare.svg"));
    EXPECT_TRUE(has(porepack("compare " + quoted(results / "lbm")).err, "the result of a stage"));
    EXPECT_TRUE(has(porepack("compare /nowhere").err, "there is no result.json of a case"));
    double lbm = 0.0, foam = 0.0;
    for (const auto& quantity : result["quantities"]) {
        for (const char* key : {"name", "value", "unit", "method", "uncertainty", "converged", "cost_s"})
            EXPECT_TRUE(quantity.contains(key)) << quantity.dump();
        if (quantity["name"] == "permeability_lbm") lbm = quantity["value"];
        if (quantity["name"] == "permeability_foam") foam = quantity["value"];
    }
    // Four voxels per diameter and one coarse mesh: this only checks that both solvers have the same scene.
    EXPECT_GT(lbm, 0.0);
    EXPECT_NEAR(foam / lbm, 1.0, 0.25);
    const std::string page = read_text(results / "report.html");
    EXPECT_TRUE(has(page, "Permeability"));
    EXPECT_TRUE(has(page, "Predicted water level over time"));       // the plots, although the path holds an apostrophe
    EXPECT_EQ(page.find("What accuracy costs"), std::string::npos);  // no figure of another machine
    for (const char* stage : {"lbm", "foam"}) EXPECT_EQ(read_json(results / stage / "result.json").at("converged"), true) << stage;
    const Json of_foam = read_json(results / "foam" / "result.json");
    for (const Json& mesh : of_foam.at("meshes")) EXPECT_EQ(mesh.at("converged"), true);
    const Json kinds = read_json(results / "tortuosity" / "result.json");
    for (const char* kind : {"geometric_paper_exact", "geometric_paper_pixels", "shortest_path", "hydraulic"})
        EXPECT_GE(kinds.at(kind).at("tortuosity_" + kinds.at(kind).at("kind").get<std::string>()).get<double>(), 1.0) << kind;
    EXPECT_GE(kinds.at("diffusive").at("tortuosity_factor").get<double>(), 1.0);
    EXPECT_TRUE(std::filesystem::exists(results / "tortuosity" / "paths_shortest.vtp"));

    // No stage is repeated; a change is detected, and only the stages that depend on it run again.
    const auto again = porepack("run " + quoted(folder.path()));
    EXPECT_EQ(again.exit_code, 0);
    for (const char* stage : {"pack", "stl", "lbm", "foam", "report"}) EXPECT_TRUE(has(again.err, std::string(stage) + ": already done"));
    folder.write("case.toml", small_case + "[tortuosity]\ndot_spacing_m = 0.004\n");
    const auto changed = porepack("run " + quoted(folder.path()));
    EXPECT_TRUE(has(changed.err, "lbm: already done"));
    EXPECT_TRUE(has(changed.err, "tortuosity: done before, but configuration changed: tortuosity"));
    // A modified result is stale, and status gives the reason.
    std::ofstream(results / "voxelise" / "pore.vti", std::ios::app) << "x";
    const auto status = porepack("status --json " + quoted(folder.path())).json();
    for (const auto& entry : status)
        if (entry["stage"] == "voxelise") {
            EXPECT_EQ(entry["state"], "stale");
            EXPECT_EQ(entry["why"], "output changed or missing: pore.vti");
        }
}

TEST(Chain, TheSphereArrayCaseInReducedSize) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    std::string text = read_text(Path(POREPACK_SOURCE_FOLDER) / "cases/sphere_array/case.toml");
    folder.write("case.toml", text);
    std::filesystem::copy_file(Path(POREPACK_SOURCE_FOLDER) / "cases/sphere_array/packing.json", folder.path() / "packing.json");
    const auto lbm = porepack("lbm --json --voxel-size 0.003125 --grids 1 " + quoted(folder.path()));
    ASSERT_EQ(lbm.exit_code, 0) << lbm.err;
    const double exact = 7.93338e-5;  // 2 a^2/(9 c K), K = 15.39949
    EXPECT_NEAR(lbm.json()["permeability_m2"].get<double>() / exact, 1.0, 0.06);
    EXPECT_EQ(lbm.json()["driven_by"], "body force");
    const auto foam = porepack("foam --json --cell-size 0.004 --meshes 1 " + quoted(folder.path()));
    ASSERT_EQ(foam.exit_code, 0) << foam.err;
    EXPECT_NEAR(foam.json()["permeability_m2"].get<double>() / exact, 1.0, 0.06);
}

TEST(Chain, TheOwnStlCaseInReducedSize) {
    const test::Folder folder;
    std::filesystem::copy_file(Path(POREPACK_SOURCE_FOLDER) / "cases/own_stl/case.toml", folder.path() / "case.toml");
    std::filesystem::copy_file(Path(POREPACK_SOURCE_FOLDER) / "cases/own_stl/grains.stl", folder.path() / "grains.stl");
    const auto output = porepack("lbm --json --voxel-size 1e-3 --grids 1 " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    EXPECT_GT(output.json()["permeability_m2"].get<double>(), 0.0);
    // The same by loose files, from the STL in millimetres.
    const auto loose =
        porepack("lbm --json --grids 1 --voxel-size 1e-3 --unit 0.001 --container box:0.05,0.05,0.15 --section 0.01,0.04 --output " +
                 quoted(folder.path() / "out") + " " + quoted(folder.path() / "grains.stl"));
    ASSERT_EQ(loose.exit_code, 0) << loose.err;
    EXPECT_NEAR(loose.json()["permeability_m2"].get<double>() / output.json()["permeability_m2"].get<double>(), 1.0, 0.02);
}

// Grains of some micrometres in air: the molecules slip on the walls, and the report says so. In water it does not.
// Films and menisci are solid for all stages after the packing; OpenFOAM, whose mesh has no menisci, is left out.
TEST(Chain, ThePorousAsphaltCaseInReducedSize) {
    const test::Folder folder;
    const std::string of_case = quoted(Path(POREPACK_SOURCE_FOLDER) / "cases" / "porous_asphalt");
    const std::string small =
        " --set container.diameter_m=0.03 --set packing.grains=24 --set geometry.voxel_size_m=1e-3 --set report.pictures=false";
    const auto porosity = [&](const char* name, const std::string& more, const char* last) {
        const Path output = folder.path() / name;
        const auto run = porepack("run --json " + of_case + small + more + " --up-to " + last + " --output " + quoted(output));
        EXPECT_EQ(run.exit_code, 0) << run.err;
        EXPECT_EQ(test::schema_faults(output), "");
        return read_json(output / "voxelise" / "result.json").at("porosity").get<double>();
    };
    const double bound = porosity("bound", " --set geometry.closing_radius_m=1e-3", "report"),
                 film = porosity("film", " --set geometry.closing_radius_m=0", "voxelise"),
                 dry = porosity("dry", " --set geometry.closing_radius_m=0 --set geometry.film_thickness_m=0", "voxelise");
    EXPECT_LT(bound, film - 0.02);
    EXPECT_LT(film, dry - 0.05);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "bound" / "foam"));
    EXPECT_TRUE(has(read_text(folder.path() / "bound" / "report.md"), "menisci between the grains count as solid"));
    const Path own = folder.write(
        "own/case.toml", read_text(Path(POREPACK_SOURCE_FOLDER) / "cases" / "porous_asphalt" / "case.toml") + "[stl]\npores = true\n");
    EXPECT_TRUE(has(porepack("run " + quoted(own.parent_path())).err, "without menisci"));
}

TEST(Chain, AGasInNarrowPoresGetsANote) {
    const test::Folder folder;
    std::filesystem::copy_file(Path(POREPACK_SOURCE_FOLDER) / "cases/own_stl/grains.stl", folder.path() / "grains.stl");
    for (const std::string fluid : {"air", "water"}) {
        folder.write("case.toml",
                     "[shape]\nkind = \"surface\"\nfile = \"grains.stl\"\nunit_m = 1e-7\n"
                     "[container]\nkind = \"box\"\nsize_m = [5e-6, 5e-6, 1.5e-5]\n"
                     "[geometry]\nvoxel_size_m = 1.5e-7\nsection_m = [1e-6, 4e-6]\nslice_pixel_m = 1e-7\nslice_spacing_m = 1e-7\n"
                     "[openfoam]\nenabled = false\n[lbm]\nfields = \"none\"\ngrids = 1\n"
                     "[tortuosity]\ndot_spacing_m = 5e-7\ndiffusive = false\nshortest_path = false\n"
                     "[report]\npictures = false\nfluid = \"" +
                         fluid + "\"\n");
        const auto output = porepack("run --output " + quoted(folder.path() / "out") + " " + quoted(folder.path()));
        ASSERT_EQ(output.exit_code, 0) << output.err;
        const bool noted = has(read_text(folder.path() / "out" / "report.md"), "the mean free path of its molecules is 0.12 times");
        EXPECT_EQ(noted, fluid == "air");
        EXPECT_EQ(has(output.err, "mean free path"), fluid == "air");
    }
}

// A scan as the start of a case: every stage that needs no grains runs, and k is that of the same voxels read directly.
TEST(Chain, FromAnImage) {
    const test::Folder folder;
    // Four posts in water, gray 180 in 40; the file has z as its fastest axis.
    constexpr int nx = 16, ny = 12, nz = 20;
    std::string bytes;
    for (int x = 0; x < nx; ++x)
        for (int y = 0; y < ny; ++y)
            for (int z = 0; z < nz; ++z) bytes += static_cast<char>((x / 4 % 2 == 1 && y / 3 % 2 == 1 && z > 4) ? 180 : 40);
    folder.write("scan.raw", bytes);
    const std::string image =
        "[image]\nfile = \"scan.raw\"\ndims = [20, 12, 16]\naxes = \"zyx\"\nvoxel_size_m = [1e-3]\nthreshold = 100\nwalls = \"half_way\"\n"
        "[geometry]\nsection_m = [0.006, 0.016]\n[lbm]\ngrids = 1\n";
    folder.write("case.toml", image);
    const auto run = porepack("run " + quoted(folder.path()));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json result = read_json(folder.path() / "results" / "result.json");
    EXPECT_EQ(result["stages"]["image"]["voxels"], Json({nx, ny, nz}));
    EXPECT_EQ(result["stages"]["image"]["container"]["size_m"], Json({0.016, 0.012, 0.02}));
    EXPECT_NEAR(result["stages"]["image"]["porosity_bed"].get<double>(), 1.0 - 0.25 * 0.75, 1e-9);
    for (const char* stage : {"voxelise", "lbm", "tortuosity", "uncertainty", "falling-head", "report"})
        EXPECT_TRUE(std::filesystem::exists(folder.path() / "results" / stage / "result.json")) << stage;
    if (test::has_schema_validator()) {
        EXPECT_EQ(test::schema_faults(folder.path() / "results"), "");
    }
    const auto direct = porepack(
        "lbm --json --grids 1 --image-dims 20,12,16 --image-axes zyx --image-voxel-size 1e-3 --image-threshold 100 --image-walls half_way "
        "--section 0.006,0.016 --output " +
        quoted(folder.path() / "out") + " " + quoted(folder.path() / "scan.raw"));
    ASSERT_EQ(direct.exit_code, 0) << direct.err;
    EXPECT_NEAR(direct.json()["permeability_m2"].get<double>() / result["stages"]["lbm"]["permeability_m2"].get<double>(), 1.0, 1e-12);
    // Walls from the gray values: the volume is kept although the threshold of 100 is not half-way, and there is an interval.
    std::string gray = image;
    gray.replace(gray.find("threshold = 100\nwalls = \"half_way\""), 34, "threshold = \"volume\"\nwalls = \"gray\"");
    gray.replace(gray.find("grids = 1"), 9, "grids = 3");
    const Path other = folder.path() / "gray";
    std::filesystem::create_directory(other);
    std::filesystem::copy(folder.path() / "scan.raw", other / "scan.raw");
    write_text(other / "case.toml", gray);
    EXPECT_TRUE(has(porepack("lbm --image-dims 20,12,16 --image-voxel-size 1e-3 --image-threshold volume --output " +
                             quoted(folder.path() / "out") + " " + quoted(folder.path() / "scan.raw"))
                        .err,
                    "the image has two values, 40 and 180: it is segmented"));
    const auto with_gray = porepack("run " + quoted(other));
    ASSERT_EQ(with_gray.exit_code, 0) << with_gray.err;
    const Json stages = read_json(other / "results" / "result.json")["stages"];
    EXPECT_NEAR(stages["image"]["porosity_bed"].get<double>(), 1.0 - 0.25 * 0.75, 0.01) << "posts of 4 x 3 voxels";
    EXPECT_EQ(stages["lbm"]["permeability_interval_m2"].size(), 2U);
    EXPECT_GT(stages["lbm"]["half_width_parts_m2"]["blur"].get<double>(), 0.0);
    EXPECT_TRUE(std::filesystem::exists(other / "results" / "image" / "gray.vti"));
    if (test::has_schema_validator()) {
        EXPECT_EQ(test::schema_faults(other / "results"), "");
    }
    // Another image: all stages are out of date. What belongs to grains is refused.
    bytes[0] = static_cast<char>(180);
    folder.write("scan.raw", bytes);
    for (const Json& entry : porepack("status --json " + quoted(folder.path())).json())
        EXPECT_EQ(entry["state"], "stale") << entry["stage"];
    folder.write("case.toml", image + "[packing]\nseed = 2\n");
    EXPECT_TRUE(has(porepack("run " + quoted(folder.path())).err, "the table [packing] has no effect on an image"));
    EXPECT_TRUE(has(porepack("lbm --image-unit 1 " + quoted(folder.path())).err, "--image-... have no effect on a case"));
}

TEST(Chain, GoesOnAfterAKillAndAfterCtrlC) {
    REQUIRE_PROGRAM("liggghts");
    for (const int signal : {SIGKILL, SIGINT}) {
        const test::Folder folder;
        std::string text = with_liggghts(small_case);
        text.replace(text.find("grains = 8"), 10, "grains = 24");
        folder.write("case.toml", text);
        const Path results = folder.path() / "results";
        // Interrupted in the middle of the pour.
        const Path script =
            folder.write("cut.sh", "\"$1\" pack \"$2\" & pid=$!; sleep 2; kill -" + std::to_string(signal) + " $pid; wait $pid; exit $?\n");
        const int end = std::system(
            ("bash " + quoted(script) + " " + test::quoted(POREPACK_PROGRAM) + " " + quoted(folder.path()) + " > /dev/null 2>&1").c_str());
        EXPECT_EQ(WEXITSTATUS(end), signal == SIGKILL ? 137 : 5);
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        EXPECT_FALSE(std::filesystem::exists(results / "pack" / "packing.json"));
        const auto after = porepack("status " + quoted(folder.path()));
        EXPECT_TRUE(has(after.out, signal == SIGKILL ? "interrupted or running" : "missing"));
        const auto again = porepack("pack " + quoted(folder.path()));
        EXPECT_EQ(again.exit_code, 0) << again.err;
        EXPECT_TRUE(std::filesystem::exists(results / "pack" / "packing.json"));
    }
}

}  // namespace
}  // namespace porepack
