// Mixtures, the extra surfaces and figure 7, through the program.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "core/json.hpp"
#include "core/table.hpp"
#include "imaging/write_volume.hpp"
#include "io/stl.hpp"
#include "packing/grains.hpp"
#include "packing/packing.hpp"
#include "scans/gray_levels.hpp"
#include "support/helpers.hpp"
#include "support/simulated_scan.hpp"
#include "support/stones.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

TEST(Mixture, IsPouredAndComesBackShapeByShape) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    const std::string container =
        "[container]\nkind = \"cylinder\"\ndiameter_m = 0.05\nheight_m = 0.12\n[packing]\nengine = \"liggghts\"\ngrains = 8\n";
    const std::string pod = "[[shape.component]]\nnumber_fraction = 0.5\nkind = \"tetrapod\"\nsphericity = 0.6\nvolume_m3 = 4e-7\n";
    const std::string star =
        "[[shape.component]]\nnumber_fraction = 0.5\nkind = \"star\"\narms = 5\ndiameter_m = 0.003\nlength_m = 0.007\n";
    folder.write("case.toml", "[shape]\nkind = \"mixture\"\n" + pod + star + container);
    const auto output = porepack("pack --json " + quoted(folder.path()));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const Json result = output.json();
    EXPECT_LT(result["pose_error_relative_to_diameter"].get<double>(), 1e-6);
    const long pods = result["grains_of_shape"]["tetrapod_1"].get<long>(), stars = result["grains_of_shape"]["star_2"].get<long>();
    EXPECT_EQ(pods + stars, 8);
    EXPECT_GT(pods, 0);
    EXPECT_GT(stars, 0);
    EXPECT_EQ(read_packing(folder.path() / "results/pack/packing.json").shapes.size(), 2U);
    folder.write("case.toml", "[shape]\nkind = \"mixture\"\n" + pod + container);
    EXPECT_TRUE(has(porepack("pack " + quoted(folder.path())).err, "two shapes or more"));
    folder.write("case.toml", "[shape]\nkind = \"mixture\"\n" + pod + star + pod + container);
    EXPECT_TRUE(has(porepack("pack " + quoted(folder.path())).err, "add up to 1.5"));
}

// A user's stone: measured, poured, and as voxels and a surface.
TEST(MeshGrains, AreSimplifiedAndPoured) {
    const test::Folder folder;
    const PolyhedronSize size = test::stone(2, 0.4, 7, 0.0);
    TriangleSurface stone;
    for (const Vec3& x : size.corners_m) stone.points.push_back({10.0 * x.x() + 40.0, 10.0 * x.y(), 10.0 * x.z()});
    for (const auto& face : size.faces) stone.triangles.push_back({face[0], face[1], face[2]});
    write_stl(folder.path() / "stone.stl", stone);
    const std::string file = quoted(folder.path() / "stone.stl");
    const Json whole = porepack("shape --json --unit 0.001 " + file).json();
    const Json few = porepack("shape --json --unit 0.001 --faces 60 " + file).json();
    EXPECT_EQ(few["faces_of_file"], 320);
    EXPECT_EQ(few["faces"], 60);
    const double volume = whole["volume_m3"].get<double>();
    EXPECT_NEAR(few["volume_m3"].get<double>() / volume, 1.0, 3e-6);
    EXPECT_LT(few["largest_deviation_m"].get<double>(), 1e-3);
    EXPECT_TRUE(has(porepack("shape --faces 60 " + file).err, "unit_m = 0.001"));
    const std::string rest =
        "faces = 60\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.03\nheight_m = 0.08\n"
        "[packing]\ngrains = 6\nfill = \"lattice\"\n[geometry]\nvoxel_size_m = 5e-4\nsection_m = [0.002, 0.008]\n";
    const std::string shape = "[shape]\nkind = \"mesh\"\nfile = \"stone.stl\"\n";
    folder.write("case.toml", shape + rest);
    EXPECT_TRUE(has(porepack("run " + quoted(folder.path())).err, "the unit of stone.stl is not known"));
    folder.write("case.toml", shape + "sphericity = 0.8\nunit_m = 0.001\n" + rest);
    EXPECT_TRUE(has(porepack("run " + quoted(folder.path())).err, "`sphericity` has no effect with kind"));
    folder.write("case.toml", shape + "unit_m = 0.001\n" + rest);
    for (const char* stage : {"voxelise", "stl"}) {
        const auto run = porepack("run --up-to " + std::string(stage) + " " + quoted(folder.path()));
        ASSERT_EQ(run.exit_code, 0) << run.err;
    }
    const Path results = folder.path() / "results";
    const Json pack = read_json(results / "pack/result.json");
    const double solid = 6.0 * volume, space = pack["bed_height_m"].get<double>() * std::numbers::pi * 0.015 * 0.015;
    EXPECT_NEAR(pack["porosity_bed"].get<double>(), 1.0 - solid / space, 1e-3);
    EXPECT_NEAR(read_json(results / "stl/result.json")["volume_m3"].get<double>() / solid, 1.0, 0.002);
    EXPECT_TRUE(read_json(results / "stl/result.json")["closed"].get<bool>());
    EXPECT_EQ(test::schema_faults(results), "");
    // Another file is another shape.
    for (auto& p : stone.points) p[2] *= 1.1;
    write_stl(folder.path() / "stone.stl", stone);
    EXPECT_TRUE(has(porepack("status " + quoted(folder.path())).out, "stone.stl"));
}

// Stones, a scan of them, and a new bed of the stones that the scan shows.
TEST(MeshGrains, AScanGivesALibraryFromWhichNewBedsArePoured) {
    const test::Folder folder;
    Packing packing{.container = parse_container("box:0.045,0.03,0.03"), .shapes = {}, .bodies = {}};
    std::vector<double> volumes;
    for (const unsigned seed : {1U, 5U, 9U}) {
        packing.shapes.push_back(
            {.id = fmt::format("stone_{}", seed), .body = make_polyhedron(test::stone(1, 0.3, seed, 0.03))->scaled(0.012)});
        const double x = 0.0075 + 0.015 * static_cast<double>(packing.bodies.size());
        packing.bodies.push_back({.shape = packing.bodies.size(), .position_m = Vec3(x, 0.015, 0.015)});
        volumes.push_back(measure(packing.shapes.back(), 1e-6).volume_m3);
    }
    const auto at = [&](const char* name) { return quoted(folder.path() / name); };
    const geometry::GrayImage image =
        test::simulated_scan(Grains(packing), packing.container, 3e-4, {.blur_voxels = 0.7, .noise = 0.02, .seed = 2});
    imaging::write_volume(folder.path() / "scan.nrrd", scans::scan_of(image, 60.0, 180.0, imaging::ValueType::uint8));
    const auto segmented = porepack("image segment --json --library true --separation 0.5 --container box:0.045,0.03,0.03 " +
                                    at("scan.nrrd") + " --output " + at("segmented"));
    ASSERT_EQ(segmented.exit_code, 0) << segmented.err;
    EXPECT_EQ(segmented.json()["library"]["stones"], 3) << segmented.out;
    EXPECT_EQ(segmented.json()["library"]["left_out"], 0);
    // They are 40 voxels wide. A shift of the surface by a twentieth of a voxel would change the volume by a percent at most.
    const TextTable table = read_text_table(folder.path() / "segmented/library/stones.csv");
    ASSERT_EQ(table.rows.size(), 3U);
    std::vector<double> found;
    for (const auto& row : table.rows) found.push_back(std::stod(row[1]));
    std::sort(found.begin(), found.end());
    std::sort(volumes.begin(), volumes.end());
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i] / volumes[i], 1.0, 0.01);

    const std::string rest =
        "unit_m = 1.0\nfaces = 40\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.04\nheight_m = 0.12\n"
        "[packing]\ngrains = 9\nfill = \"lattice\"\n";
    const auto with = [&](const std::string& keys) {
        folder.write("case.toml", "[shape]\nkind = \"library\"\n" + keys + rest);
        return porepack("pack --json " + quoted(folder.path()));
    };
    const auto poured = with("folder = \"segmented/library\"\nlibrary_by = \"volume\"\n");
    ASSERT_EQ(poured.exit_code, 0) << poured.err;
    const Packing bed = read_packing(folder.path() / "results/pack/packing.json");
    EXPECT_EQ(bed.shapes.size(), 3U);
    EXPECT_EQ(bed.bodies.size(), 9U);
    double solid = 0.0;
    for (const Body& body : bed.bodies) solid += measure(bed.shapes[body.shape], 1e-5).volume_m3;
    const double height = poured.json()["bed_height_m"].get<double>();
    EXPECT_NEAR(poured.json()["porosity_bed"].get<double>(), 1.0 - solid / (std::numbers::pi * 0.02 * 0.02 * height), 2e-3);

    EXPECT_TRUE(has(with("").err, "no folder is given"));
    EXPECT_TRUE(has(with("folder = \"none\"\n").err, "cannot be read"));
    EXPECT_TRUE(has(with("folder = \".\"\n").err, "the library has 0 meshes"));
    EXPECT_TRUE(has(with("folder = \"segmented/library\"\nfile = \"a.stl\"\n").err, "`file` has no effect"));
    folder.write("segmented/library/bad.stl", "solid x\n");
    EXPECT_TRUE(has(with("folder = \"segmented/library\"\n").err, "bad.stl"));
}

TEST(ExtraSurfaces, AreWrittenAsAskedFor) {
    const test::Folder folder;
    Packing packing{.container = parse_container("cylinder:0.03,0.06"), .shapes = {make_preset(ShapeKind::rod, 0.006, 0.01)}, .bodies = {}};
    for (int i = 0; i < 3; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.007 * (i - 1), 0.0, 0.02)});
    write_packing(folder.path() / "packing.json", packing);
    const auto output = porepack("stl --pores --clip true --one-file-a-grain true --also both --millimetres --section 0.015,0.025 --json " +
                                 quoted(folder.path() / "packing.json"));
    ASSERT_EQ(output.exit_code, 0) << output.err;
    for (const char* name : {"solid.stl", "pores.stl", "clipped.stl", "solid.ply", "solid.vtp", "solid_mm.stl", "grains/grain_00003.stl"})
        EXPECT_TRUE(std::filesystem::exists(folder.path() / name)) << name;
    const std::string pores = read_text(folder.path() / "pores.stl");
    for (const char* region : {"solid inlet", "solid outlet", "solid wall", "solid grains"})
        EXPECT_TRUE(pores.find(region) != std::string::npos);
    EXPECT_TRUE(has(read_text(folder.path() / "solid_mm.stl").substr(0, 80), "millimetre"));
    const double metres = porepack("shape --json " + quoted(folder.path() / "solid.stl")).json()["volume_m3"].get<double>();
    const auto millimetres = porepack("shape --json --unit 0.001 " + quoted(folder.path() / "solid_mm.stl"));
    EXPECT_NEAR(millimetres.json()["volume_m3"].get<double>() / metres, 1.0, 1e-5);
    EXPECT_EQ(porepack("shape " + quoted(folder.path() / "no.stl")).exit_code, 2);
    packing.container = parse_container("box:0.03,0.03,0.06:periodic");
    write_packing(folder.path() / "packing.json", packing);
    EXPECT_TRUE(has(porepack("stl --pores " + quoted(folder.path() / "packing.json")).err, "no inlet, outlet or wall"));
}

TEST(Report, SaysWhyAPictureIsMissingAndComesBackWhenDeleted) {
    const test::Folder folder;
    Packing packing{
        .container = parse_container("box:0.1,0.1,0.1:periodic"), .shapes = {make_preset(ShapeKind::sphere, 0.08, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.05, 0.05, 0.05)});
    write_packing(folder.path() / "packing.json", packing);
    folder.write(
        "case.toml",
        "[shape]\nkind = \"sphere\"\ndiameter_m = 0.08\n[container]\nkind = \"box\"\nsize_m = [0.1, 0.1, 0.1]\nperiodic = [true, true, "
        "true]\n[packing]\nengine = \"none\"\nfile = \"packing.json\"\n[geometry]\nvoxel_size_m = 0.005\nslice_pixel_m = "
        "0.002\nslice_spacing_m = 0.005\n[lbm]\ngrids = 1\n[openfoam]\nenabled = false\n[tortuosity]\nslice_spacing_m = 0.005\n");
    // Without xvfb-run and a display there is no picture; the rest of PATH is kept.
    folder.write("bin/keep", "");
    for (const char* program : {"sh", "timeout", "gnuplot", "dpkg-query", "mpirun"})
        if (const auto found = find_program(program)) std::filesystem::create_symlink(*found, folder.path() / "bin" / program);
    const auto first = porepack("run " + quoted(folder.path()), "env -u DISPLAY PATH=" + quoted(folder.path() / "bin"));
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_TRUE(has(read_text(folder.path() / "results/report.html"), "No picture of the packing"));
    std::filesystem::remove(folder.path() / "results/report.html");
    folder.write("results/result.json", "{\"forged\": true}");
    ASSERT_EQ(porepack("run " + quoted(folder.path())).exit_code, 0);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "results/report.html"));
    EXPECT_FALSE(has(read_text(folder.path() / "results/result.json"), "forged"));
    EXPECT_EQ(test::schema_faults(folder.path() / "results"), "");
    // A damaged manifest means that the stage is repeated, not an error; --output sends results elsewhere.
    folder.write("results/pack/manifest.json", "{}");
    EXPECT_EQ(porepack("status " + quoted(folder.path())).exit_code, 0);
    EXPECT_EQ(porepack("pack " + quoted(folder.path()) + " --output " + quoted(folder.path() / "other")).exit_code, 0);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "other/pack/packing.json"));
}

}  // namespace
}  // namespace porepack
