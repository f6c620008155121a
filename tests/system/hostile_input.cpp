// Hostile input: damaged files, impossible frames, sudden ends. Never a crash, never a meaningless number.
#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "converters/surface.hpp"
#include "core/json.hpp"
#include "imaging/write_volume.hpp"
#include "io/image.hpp"
#include "packing/packing.hpp"
#include "scans/gray_levels.hpp"
#include "support/helpers.hpp"
#include "support/simulated_scan.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

void expect_fault(const std::string& call, const std::string& message, int code = 2) {
    const auto output = porepack(call);
    EXPECT_EQ(output.exit_code, code) << call << "\n" << output.err;
    EXPECT_TRUE(has(output.err, message)) << call;
}

Packing three_spheres(const std::string& container = "box:0.03,0.03,0.06") {
    Packing packing{.container = parse_container(container), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    for (int i = 0; i < 3; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.015, 0.015, 0.006 + 0.011 * i)});
    return packing;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(HostileImage, GridAndContainerMustFit) {
    const test::Folder folder;
    PhaseImage image{.grid = {.cells = {10, 10, 10}, .origin_m = {0, 0, 0}, .spacing_m = {1e-3, 1e-3, 1e-3}},
                     .phase = std::vector<std::uint8_t>(1000, Phase::pore),
                     .notes = {{"section", "nan,nan"}}};
    const Path file = folder.path() / "pore.vti";
    write_phase_image(file, image);
    image.phase[555] = Phase::grain;
    write_phase_image(file, image);
    const std::string unit = " --image-unit 1 --image-pore 1", box = unit + " --container box:0.01,0.01,0.01 ";
    expect_fault("lbm " + quoted(file) + box, "is not \"z0,z1\"");
    expect_fault("lbm " + quoted(file) + box + "--section 5,6", "not in the image");
    expect_fault("lbm " + quoted(file) + box + "--section 0.008,0.002", "not in the image");
    expect_fault("lbm " + quoted(file) + unit + " --container box:0.05,0.01,0.01 --section 0,0.01",
                 "0.01 m wide along axis 0, the container 0.05");
    for (const char* spacing : {"0 0 0", "nan 1 1", "-1 1 1"}) {
        const Path bad =
            folder.write("bad.vti", replaced(read_text(file), "Spacing=\"0.001 0.001 0.001\"", std::string("Spacing=\"") + spacing + "\""));
        EXPECT_EQ(porepack("lbm " + quoted(bad) + box).exit_code, 2) << spacing;
    }
    image.notes = {{"container", "{{"}};
    write_phase_image(file, image);
    expect_fault("lbm " + quoted(file), "is not JSON");
}

// Each of these gave a wrong k without a word before.
TEST(HostileImage, WhatWasWrongInSilence) {
    const test::Folder folder;
    PhaseImage image{.grid = {.cells = {10, 10, 20}, .origin_m = {0, 0, 0}, .spacing_m = {1e-3, 1e-3, 1e-3}},
                     .phase = std::vector<std::uint8_t>(2000, Phase::pore),
                     .notes = {}};
    for (int k = 4; k < 16; ++k)
        for (int j = 3; j < 7; ++j) image.phase[image.grid.index(4, j, k)] = Phase::grain;
    const Path file = folder.path() / "pore.vti";
    write_phase_image(file, image);
    const std::string in = "lbm --image-pore 1 " + quoted(file);
    expect_fault("lbm --image-unit 1 " + quoted(file), "which values are pores?");
    expect_fault(in, "but not its unit");
    expect_fault(in + " --image-voxel-size 2e-3", "and 0.002 x 0.002 x 0.002 m are given");
    expect_fault(in + " --image-unit 1 --container box:0.01,0.01,0.01",
                 "the image reaches from 0 to 0.02 m, the container from 0 to 0.01 m");
    expect_fault(in + " --image-unit 1 --container box:0.01,0.01,0.02:periodic --section 0.002,0.015", "periodic along z");
    expect_fault("lbm " + quoted(folder.write("p.json", "{}")) + " --image-unit 1", "--image-... have no effect here");
    const std::string text = read_text(file);
    for (const auto& [from, to, message] :
         {std::tuple("Piece Extent=\"0 10 0 10 0 20\"", "Piece Extent=\"0 10 0 10 0 10\"", "do not fill WholeExtent"),
          {"Spacing=\"0.001 0.001 0.001\"", "Spacing=\"0.001 0.001 0.002\"", "no cubes"},
          {"Spacing=\"0.001 0.001 0.001\"", "Spacing=\"nan 0.001 0.001\"", "Spacing is not 3 numbers"},
          {"Origin=\"0 0 0\"", "Origin=\"inf 0 0\"", "Origin is not 3 numbers"},
          {"Direction=\"1 0 0 0 1 0 0 0 1\"", "Direction=\"1 0 0.5 0 1 0 0 0 1\"", "oblique"},
          {"type=\"UInt8\"", "type=\"UInt16\"", "values than the image"}}) {
        const Path bad = folder.write("bad.vti", replaced(text, from, to));
        expect_fault("lbm --image-pore 1 " + quoted(bad) + " --image-unit 1", message);
    }
    // Water outside a cylinder is left out: a column of 10 x 10 voxels and the circle in it.
    image.phase.assign(2000, Phase::pore);
    image.phase[image.grid.index(5, 5, 10)] = Phase::grain;
    write_phase_image(file, image);
    const auto round =
        porepack("lbm --json --walls bounce_back --grids 1 --image-unit 1 --image-pore 1 --ends planes --container cylinder:0.01,0.02 " +
                 quoted(file) + " --output " + quoted(folder.path() / "round"));
    ASSERT_EQ(round.exit_code, 0) << round.err;
    EXPECT_EQ(round.json()["fine"]["fluid_nodes"], 80 * 20 - 1) << "cells whose centres are in the circle";
}

// Walls from gray values: each of these crashed, or gave a number without a word.
TEST(HostileImage, GrayImagesAndTheirFlags) {
    const test::Folder folder;
    const Packing packing = three_spheres("box:0.03,0.03,0.036");
    const geometry::GrayImage scan = test::simulated_scan(Grains(packing), packing.container, 1e-3, {.blur_voxels = 0.6, .noise = 0.02});
    imaging::write_volume(folder.path() / "scan.nrrd", scans::scan_of(scan, 30.0, 180.0));
    const std::string file = quoted(folder.path() / "scan.nrrd"), threshold = " --image-threshold volume";
    const std::string out = " --output " + quoted(folder.path() / "out");
    for (const char* command : {"foam --dry-run ", "foam ", "stl "}) {
        const auto output = porepack(command + file + threshold + out);
        EXPECT_EQ(output.exit_code, 2) << command << output.err;
        EXPECT_TRUE(has(output.err, "not of an image") || has(output.err, "the input is an image")) << command;
    }
    expect_fault("voxelise " + file + " --image-pore 30 --image-threshold 100" + out, "`threshold` has no effect");
    expect_fault("voxelise " + file + " --image-threshold middle" + out, "`threshold` is neither a number nor one of its words");
    expect_fault("voxelise " + file + " --image-pore dark" + out, "`pore` is not a number or a list of numbers");
    expect_fault("voxelise " + file + " --image-threshold 100 --image-walls half_way --image-smoothing-voxels 1" + out,
                 "`smoothing_voxels` has no effect: the walls lie half-way between voxels");
    expect_fault("image segment " + file + " --container cylinder:0.05,0.036" + out, "the image is 0.03 m wide");
    expect_fault("voxelise " + file + " --image-find-container" + threshold + out, "the image shows no tube");
    const auto segmented = porepack("image segment --keep-cut-grains " + file + " --output " + quoted(folder.path() / "seg"));
    ASSERT_EQ(segmented.exit_code, 0) << segmented.err;
    const std::string gray = quoted(folder.path() / "seg" / "gray.vti");
    expect_fault("voxelise " + gray + " --container cylinder:0.03,0.036" + out, "the image states another container");
    expect_fault("voxelise " + gray + " --image-walls half_way" + out, "`walls` has no effect");
    expect_fault("image segment " + quoted(folder.path() / "seg" / "pore.vti") + out, "segmented already");
    const auto slices = porepack("tortuosity geometric_paper " + gray + out);
    EXPECT_EQ(slices.exit_code, 0) << slices.err;
}

TEST(HostileImage, ACutPictureIsNamed) {
    const test::Folder folder;
    write_packing(folder.path() / "packing.json", three_spheres());
    ASSERT_EQ(porepack("slices --spacing 5e-3 --pixel 1e-3 --section 0.005,0.03 " + quoted(folder.path() / "packing.json")).exit_code, 0);
    Path picture;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
        if (entry.path().filename() == "slice_0001.png") picture = entry.path();
    ASSERT_FALSE(picture.empty());
    std::filesystem::resize_file(picture, 60);
    expect_fault("tortuosity geometric_paper " + quoted(picture.parent_path()), "the image is damaged or incomplete");
}

TEST(HostilePacking, EachFaultIsNamed) {
    const test::Folder folder;
    const Path file = folder.path() / "packing.json";
    write_packing(file, three_spheres());
    const std::string good = read_text(file);
    const auto fault = [&](const std::string& text, const std::string& message) {
        expect_fault("voxelise --voxel-size 1e-3 --section 0.005,0.03 " + quoted(folder.write("bad.json", text)), message);
    };
    fault(replaced(good, "\"version\":1", "\"version\":1,\"unit\":\"mm\""), "unknown key `unit`");
    fault(replaced(good, "0.006", "1e400"), "not valid JSON");
    Packing packing = three_spheres();
    packing.shapes.push_back(packing.shapes.front());
    write_packing(file, packing);
    fault(read_text(file), "same id");
    packing = three_spheres();
    packing.bodies[1] = packing.bodies[0];
    write_packing(file, packing);
    fault(read_text(file), "the same grain at the same place");
    for (const Vec3& at : {Vec3(0.015, 0.015, -0.006), Vec3(0.015, 0.015, 0.066), Vec3(-0.0051, 0.015, 0.03)}) {
        packing = three_spheres();
        packing.bodies[1].position_m = at;
        write_packing(file, packing);
        fault(read_text(file), "outside the container");
    }
    write_packing(file, three_spheres());
    const std::string in = quoted(file);
    expect_fault("voxelise --voxel-size 1e-3 --section 0.04,0.05 " + in, "not in the bed: free space would count");
    expect_fault("voxelise --voxel-size 1e-3 --section 0.0,0.05 " + in, "not in the bed: free space would count");
    expect_fault("voxelise --voxel-size 1e-3 --section 0.005,0.03 --reservoir 1e5 " + in, "cells");
    expect_fault("lbm --voxel-size 1e-3 --section 0.005,0.007 --grid-ratio 1.1 " + in, "same voxel size");
    expect_fault("slices --section 0.005,0.03 --spacing 1e-9 " + in, "slices");
    expect_fault("slices --section 0.005,0.03 --pixel 1 " + in, "pixels");
    expect_fault("tortuosity geometric_paper --section 0.005,0.03 --dot-spacing 1e-9 " + in, "too many dots");
    expect_fault("voxelise --container box:1,1,1 " + in, "its own container");
    expect_fault(
        "voxelise --voxel-size 1e-3 --section 0.01101,0.01199 " + quoted(folder.write("gap.json", replaced(good, "0.017", "0.018"))),
        "there is no grain in the section");
    expect_fault("stl --surface-deviation 1 " + in, "1 m would change the grains");
    expect_fault("stl --contact-gap 1 " + in, "at most 0.001 m");
    expect_fault("stl --surface-deviation 9e-4 " + in, "the volume of the surface differs");
    // Through the wall, inside each other, turned copies of one grain.
    packing = three_spheres();
    packing.bodies[1].position_m.x() -= 0.0125;
    write_packing(file, packing);
    expect_fault("voxelise --voxel-size 1e-3 " + in, "into the wall or the floor");
    packing = three_spheres();
    packing.bodies[1].position_m = packing.bodies[0].position_m + Vec3(0.003, 0.0, 0.0);
    write_packing(file, packing);
    expect_fault("voxelise --voxel-size 1e-3 " + in, "bodies 0 and 1 overlap by");
    packing.overlap_allowed = true;
    write_packing(file, packing);
    EXPECT_EQ(porepack("voxelise --json --voxel-size 1e-3 --section 0.006,0.02 " + in).exit_code, 0);
    packing = three_spheres();
    packing.bodies[1] = packing.bodies[0];
    packing.bodies[1].orientation.coeffs() *= -1.0;
    write_packing(file, packing);
    expect_fault("voxelise --voxel-size 1e-3 " + in, "overlap by");
    fault(replaced(good, "\"a_m\":[0.0,0.0,0.0],", ""), "`a_m` is missing");
    fault(replaced(good, "\"kind\":\"box\"", "\"kind\":\"box\",\"diameter_m\":0.1"), "unknown key `diameter_m`");
    fault(replaced(good, "\"radius_m\":", "\"radius_m\":0.004,\"radius_m\":"), "\"radius_m\" is there twice");
    write_packing(file, three_spheres("box:0.03,0.03,0.06:periodic"));
    fault(replaced(read_text(file), "0.015,0.015,0.006", "3e10,0.015,0.006"), "boxes away from the periodic box");
    expect_fault("lbm --voxel-size 1e-3 --section 0.01,0.03 " + in, "taken as a whole");
    expect_fault("lbm --voxel-size 1e-3 --reservoir 0.01 " + in, "no reservoir");
}

// A place in a periodic box is known but for whole boxes, and a shape that no body has says nothing about the packing.
TEST(HostilePacking, FarBodiesAndUnusedShapesChangeNothing) {
    const test::Folder folder;
    const auto numbers = [&](const Packing& packing) {
        write_packing(folder.path() / "packing.json", packing);
        const auto output = porepack("voxelise --json " + quoted(folder.path() / "packing.json"));
        EXPECT_EQ(output.exit_code, 0) << output.err;
        const Json json = Json::parse(output.out);
        return std::pair(json.at("porosity").get<double>(), json.at("voxel_size_m").get<double>());
    };
    Packing packing = three_spheres("box:0.03,0.03,0.06:periodic");
    const auto expected = numbers(packing);
    packing.bodies[1].position_m += Vec3(0.03 * 1000, -0.03 * 500, 0.06 * 20);
    packing.shapes.push_back(make_preset(ShapeKind::sphere, 1e-4, 0.0));
    packing.shapes.back().id = "unused";
    const auto found = numbers(packing);
    EXPECT_NEAR(found.first, expected.first, 1e-9);
    EXPECT_EQ(found.second, expected.second);
}

TEST(HostileFile, OnlyRegularFilesAreRead) {
    const test::Folder folder;
    const Path pipe = folder.path() / "pipe.json";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const std::string& input : {std::string("/dev/zero"), quoted(pipe)})
        for (const char* command : {"run ", "lbm --container box:1,1,1 ", "falling-head analyse --sample-length 0.1 "})
            EXPECT_EQ(porepack(command + input, "timeout 20").exit_code, 2) << command << input;
    expect_fault("falling-head analyse --sample-length 0.1 /dev/zero", "a regular file is needed");
    expect_fault("pack " + quoted(pipe), "a regular file is needed");
    const Path large = folder.write("large.toml", "");
    std::filesystem::resize_file(large, 20'000'000);
    expect_fault("pack " + quoted(large), "at most 16 MB");
    write_packing(folder.path() / "packing.json", three_spheres());
    const auto many = porepack("voxelise --voxel-size 1e-3 " + quoted(folder.path() / "packing.json"), "OMP_NUM_THREADS=100000");
    EXPECT_EQ(many.exit_code, 2);
    EXPECT_TRUE(has(many.err, "OMP_NUM_THREADS"));
}

// Levels on a straight line: no falling head, and nothing to fit.
TEST(HostileCurve, ALongStraightLineEnds) {
    const test::Folder folder;
    std::string text = "time_s,level_m\n";
    for (int i = 0; i < 100000; ++i) text += fmt::format("{},{}\n", 1e-5 * i, 1.6 - 1e-5 * i);
    const auto output = porepack(
        "falling-head analyse --json --sample-length 0.12 " + quoted(folder.write("line.csv", text)) + " --output " + quoted(folder.path()),
        "timeout 60");
    EXPECT_EQ(output.exit_code, 0) << output.err;
    EXPECT_TRUE(has(output.out, "doubtful"));
}

// A box with its corner at `low`; inside out when `inward`.
void add_box(TriangleSurface& surface, double low, double size, bool inward) {
    const int first = static_cast<int>(surface.points.size());
    for (int c = 0; c < 8; ++c) surface.points.push_back({low + size * (c & 1), low + size * (c >> 1 & 1), low + size * (c >> 2 & 1)});
    constexpr int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& q : quads)
        for (int half = 0; half < 2; ++half) {
            std::array<int, 3> t = {first + q[0], first + q[1 + half], first + q[2 + half]};
            if (inward) std::swap(t[1], t[2]);
            surface.triangles.push_back(t);
        }
}

TEST(HostileStl, ShellsMustBeTurnedAsTheyAreNested) {
    const test::Folder folder;
    const auto fault_of = [&](double low, double size, bool inward) {
        TriangleSurface surface;
        add_box(surface, 0.01, 0.02, false);
        add_box(surface, low, size, inward);
        return check_surface(surface).fault;
    };
    EXPECT_EQ(fault_of(0.04, 0.01, false), "");   // two bodies
    EXPECT_EQ(fault_of(0.015, 0.005, true), "");  // a cavity
    EXPECT_TRUE(has(fault_of(0.04, 0.01, true), "turned inward although 0 shells"));
    EXPECT_TRUE(has(fault_of(0.015, 0.005, false), "turned outward although 1 shells"));
}

TEST(HostileStl, AsciiNumbersAreReadWholly) {
    const test::Folder folder;
    const std::string good =
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0,5 1 0\nendloop\nendfacet\nendsolid a\n";
    expect_fault("voxelise --container box:1,1,1 --voxel-size 0.1 " + quoted(folder.write("a.stl", good)), "`0,5` is not a number");
}

TEST(HostileStl, NothingIsPouredAndNothingHangsUnsaid) {
    const test::Folder folder;
    write_stl(folder.path() / "stone.stl", make_surface(three_spheres(), {}).surface);
    const std::string stone =
        "[shape]\nkind = \"stl\"\nfile = \"stone.stl\"\n[container]\nkind = \"box\"\nsize_m = [0.03, 0.03, 0.06]\n[geometry]\nsection_m = "
        "[0.005, 0.03]\n";
    (void)folder.write("case.toml", stone + "[packing]\ngrains = 40\n");
    expect_fault("run " + quoted(folder.path()) + " --dry-run", "the table [packing] has no effect on the grains of an STL file");
    (void)folder.write("case.toml", stone);
    EXPECT_EQ(porepack("run " + quoted(folder.path()) + " --dry-run").exit_code, 0);
    const auto seen = porepack("voxelise " + quoted(folder.path() / "stone.stl") + " --container box:0.03,0.03,0.06 --section 0.005,0.03 " +
                               "--voxel-size 1e-3 --output " + quoted(folder.path() / "o"));
    EXPECT_TRUE(has(seen.err, "% of the section: k is that of single bodies"));
}

// A bed of columns, free layers above it.
TEST(HostileImage, ABedThatEndsInTheImageIsSeen) {
    const test::Folder folder;
    PhaseImage image{.grid = {.cells = {24, 24, 60}, .origin_m = {0, 0, 0}, .spacing_m = {1e-3, 1e-3, 1e-3}},
                     .phase = std::vector<std::uint8_t>(24 * 24 * 60, Phase::pore),
                     .notes = {}};
    for (int k = 0; k < 40; ++k)
        for (int j = 0; j < 24; ++j)
            for (int i = 0; i < 24; ++i)
                if ((i / 4 + j / 4 + k / 4) % 2 == 0) image.phase[image.grid.index(i, j, k)] = Phase::grain;
    write_phase_image(folder.path() / "a.vti", image);
    const std::string call =
        "voxelise " + quoted(folder.path() / "a.vti") + " --image-unit 1 --image-pore 1 --output " + quoted(folder.path() / "o");
    const auto whole = porepack(call);
    EXPECT_TRUE(has(whole.err, "the bed ends inside the image, at 0 and 0.04 m; the section is 0 to 0.03")) << whole.err;
    const auto beyond = porepack(call + " --section 0.01,0.055");
    EXPECT_TRUE(has(beyond.err, "reaches beyond the bed (0 to 0.04 m)")) << beyond.err;
}

TEST(NewCase, IsACopyWithoutResults) {
    const test::Folder folder;
    const std::string target = quoted(folder.path() / "mine");
    EXPECT_EQ(porepack("new " + target + " --from sphere_array").exit_code, 0);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "mine/case.toml"));
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "mine/packing.json"));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "mine/results"));
    EXPECT_EQ(porepack("run " + target + " --dry-run").exit_code, 0);
    expect_fault("new " + target, "exists and is not empty");
    expect_fault("new " + quoted(folder.path() / "other") + " --from ../cases", "there is no case");
}

TEST(HostileOutput, InputsAndForeignFoldersStay) {
    const test::Folder folder;
    write_packing(folder.path() / "packing.json", three_spheres());
    ASSERT_EQ(porepack("stl " + quoted(folder.path() / "packing.json")).exit_code, 0);
    const std::string before = read_text(folder.path() / "solid.stl");
    expect_fault("stl --container box:0.03,0.03,0.06 " + quoted(folder.path() / "solid.stl"), "overwrite its own input");
    EXPECT_EQ(read_text(folder.path() / "solid.stl"), before);
    EXPECT_EQ(WEXITSTATUS(std::system((test::quoted(POREPACK_PROGRAM) + " shape sphere --diameter 0.01 > /dev/full 2> /dev/null").c_str())),
              5);
    EXPECT_EQ(WEXITSTATUS(std::system((test::quoted(POREPACK_PROGRAM) + " run nope 2> /dev/full").c_str())), 2);
    if (!find_program("simpleFoam")) return;
    folder.write("foam/thesis.txt", "years of work");
    expect_fault("foam --cell-size 3e-3 --meshes 1 --section 0.01,0.02 " + quoted(folder.path() / "packing.json"), "is in the way");
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "foam/thesis.txt"));
}

}  // namespace
}  // namespace porepack
