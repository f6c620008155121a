// Bad input on the command line: message and exit code, and no partly written files.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "packing/packing.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

const std::string head =
    "[shape]\nkind = \"tetrapod\"\nsphericity = 0.53\nvolume_m3 = 7.33e-7\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.05\nheight_m = "
    "0.15\n";

void expect_fault(const std::string& toml, const std::string& message, const std::string& command = "run") {
    const test::Folder folder;
    folder.write("case.toml", toml);
    const auto output = porepack(command + " " + quoted(folder.path()));
    EXPECT_EQ(output.exit_code, 2) << toml;
    EXPECT_TRUE(has(output.err, message)) << toml;
}

void write_spheres(const Path& file, double gap = 0.0, int count = 3) {
    Packing packing{
        .container = parse_container("cylinder:0.03,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    for (int i = 0; i < count; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.0, 0.0, 0.005 + (0.01 + gap) * i)});
    write_packing(file, packing);
}

TEST(BadCase, EachHasItsMessage) {
    EXPECT_EQ(porepack("run /no/such/case").exit_code, 2);
    EXPECT_TRUE(has(porepack("run /no/such/case").err, "no such case"));
    expect_fault("", "[shape] is missing");
    expect_fault("[shape\n", "not valid TOML");
    expect_fault(head + "[lmb]\n", "perhaps [lbm]");
    expect_fault(head + "[lbm]\ntolerence = 1\n", "perhaps `tolerance`");
    expect_fault(head + "[section]\nsection_m = [0.01, 0.02]\n", "the key belongs to [geometry]");
    expect_fault(head + "[packings]\nuntil_sure = 0.001\n", "`packings.until_sure` is out of range");
    expect_fault(head + "[geometry]\nvoxel_size = 1e-3\n", "the unit is missing: write `voxel_size_m`");
    expect_fault(head + "[geometry]\nvoxel_size_m = 0.1\n[packing]\nengine = \"none\"\nfile = \"p.json\"\n", "no such file");
    expect_fault("[shape]\nkind = \"tetrapod\"\nsphericity = 1.5\nvolume_m3 = 7e-7\n[container]\ndiameter_m = 0.05\nheight_m = 0.1\n",
                 "0 < value <= 1");
    expect_fault("[shape]\nkind = \"tetrapod\"\nsphericity = nan\nvolume_m3 = 7e-7\n[container]\ndiameter_m = 0.05\nheight_m = 0.1\n",
                 "out of range: nan");
    expect_fault("[shape]\nkind = \"tetrapod\"\nsphericity = 0.53\n[container]\ndiameter_m = 0.05\nheight_m = 0.1\n", "needs volume_m3");
    // Impossible sizes: millimetres instead of metres.
    expect_fault("[shape]\nkind = \"tetrapod\"\nsphericity = 0.53\nvolume_m3 = 733\n[container]\ndiameter_m = 0.05\nheight_m = 0.1\n",
                 "too large for the container");
    expect_fault(head + "[packing]\ntime_step_s = 1e-3\n", "the time step 0.001 s is too long");
    expect_fault(head + "[packing]\nnormal_stiffness_N_per_m = 10\n", "contacts are too soft");
    expect_fault(head + "[packing]\ntime_step_s = 1e-12\n", "the time step 1e-12 s is too short");
    expect_fault(head + "[packing]\nfile = \"p.json\"\n", "`file` has no effect");
    expect_fault(head + "periodic = [true, true, false]\n", "`periodic` has no effect here");
    expect_fault("[shape]\nkind = \"sphere\"\ndiameter_m = 0.01\n[container]\nkind = \"box\"\nsize_m = [0.1, 0.1, 0.1]\ndiameter_m = 0.1\n",
                 "`diameter_m` has no effect here");
    // Found before the grains are poured.
    expect_fault(head + "[lbm]\ndirection = \"x\"\n", "periodic along x");
    expect_fault(head + "[geometry]\nsection_m = [0.02, 0.3]\n", "is not possible");
    expect_fault("[shape]\nkind = \"surface\"\n[container]\ndiameter_m = 0.05\nheight_m = 0.1\n", "needs a file");
}

TEST(BadFlags, EachHasItsMessage) {
    const test::Folder folder;
    write_spheres(folder.path() / "packing.json");
    const std::string in = quoted(folder.path() / "packing.json");
    const auto fault = [&](const std::string& call, const std::string& message, int code = 2) {
        const auto output = porepack(call);
        EXPECT_EQ(output.exit_code, code) << call << output.err;
        EXPECT_TRUE(has(output.err, message)) << call;
    };
    fault("frobnicate", "error:");
    fault("lbm " + in + " one two", "not expected here: one two");
    fault("run " + quoted(Path(POREPACK_SOURCE_FOLDER) / "cases" / "quickstart") + " --output x --set lbm.tolerance=7 --dry-run",
          "where:   --set lbm.tolerance");
    fault("lbm", "input is required");
    fault("lbm " + in + " --voxel-size -1", "--voxel-size");
    fault("lbm " + in + " --voxel-size nan", "out of range: nan");
    fault("lbm " + in + " --voxel-size 0.2", "larger than the grain");
    fault("lbm " + in + " --voxel-size 1e-6 --section 0.01,0.02", "cells");
    fault("lbm " + in + " --voxel-size 2.4e-5 --section 0.01,0.02", "free");  // does not fit into memory: refused before it is allocated
    fault("lbm " + in + " --direction x --voxel-size 1e-3 --section 0.01,0.02", "periodic along x");
    fault("lbm " + in + " --direction w --voxel-size 1e-3", "is not known");
    fault("lbm " + in + " --section 0.02,0.01 --voxel-size 1e-3", "0 <= z0 < z1");
    fault("voxelise " + in + " --voxel-size 1e-3 --trim 0.02", "nothing is left of the bed");
    fault("shape tetrapod --sphericity 1.5 --volume 1e-6", "--sphericity");
    fault("shape heart --volume 1e-6", "is not known");
    fault("shape tetrapod", "size is missing");
    fault("benchmark nothing", "no such benchmark");
    fault("benchmark gray --seed 1", "--seed has no effect");
    fault("tortuosity speed " + in, "speed");
    fault("falling-head simulate --permeability -1", "must be positive");
    fault("lbm " + in + " --threads 0", "--threads");
    fault("lbm " + quoted(folder.write("x.txt", "x")), "cannot tell what");
    fault("lbm " + in + " --voxelsize 1e-3", "perhaps `--voxel-size`");
    fault("voxelize " + in, "perhaps `voxelise`");
    const std::string a_case = "run --dry-run " + quoted(folder.write("case/case.toml", head)) + " ";
    fault(a_case + "--set packing.seed=5", "name another folder with --output");
    const std::string elsewhere = a_case + "--output " + quoted(folder.path() / "elsewhere") + " ";
    fault(elsewhere + "--set packing.sede=5", "perhaps `seed`");
    fault(elsewhere + "--set pakcing.seed=5", "there is no table [pakcing]");
    fault(elsewhere + "--set seed", "sets nothing");
    fault(elsewhere + "--set packing.seed=many", "is not");
    const auto planned = porepack(elsewhere + "--json --set packing.seed=5 --set lbm.grids=1");
    ASSERT_EQ(planned.exit_code, 0) << planned.err;
    EXPECT_EQ(planned.json().at("configuration").at("packing").at("seed"), 5);
    EXPECT_EQ(planned.json().at("configuration").at("lbm").at("grids"), 1);
    // A reader that has seen enough.
    EXPECT_EQ(std::system(("bash -c " + quoted("set -o pipefail; " + quoted(POREPACK_PROGRAM) + " keys | head -n 1 > /dev/null")).c_str()),
              0);
    fault("lbm " + in + " --max-steps 40 --grids 1 --voxel-size 1e-3 --section 0.01,0.02", "not steady after 40 steps", 3);
}

TEST(BadStl, EachHasItsMessage) {
    const test::Folder folder;
    write_spheres(folder.path() / "packing.json", 0.001);
    ASSERT_EQ(porepack("stl " + quoted(folder.path() / "packing.json")).exit_code, 0);
    const std::string bytes = read_text(folder.path() / "solid.stl");
    const auto fault = [&](const std::string& content, const std::string& flags, const std::string& message) {
        const Path file = folder.write("bad.stl", content);
        const auto output = porepack("voxelise --voxel-size 1e-3 " + flags + " " + quoted(file));
        EXPECT_EQ(output.exit_code, 2) << message << output.err;
        EXPECT_TRUE(has(output.err, message));
        EXPECT_FALSE(std::filesystem::exists(folder.path() / "pore.vti"));
    };
    const std::string container = "--container cylinder:0.03,0.06";
    fault(bytes, "", "needs a container");
    fault(bytes, "--container cylinder:30,60", "much smaller than the container");
    fault(bytes, container + " --unit 1000", "millimetres");
    fault(bytes, "--container cylinder:0.03,0.02", "sticks out of the container");
    fault("", container, "empty");
    fault(bytes.substr(0, 5000), container, "the STL file is incomplete");
    std::string open = bytes;
    std::uint32_t count = 0;
    std::memcpy(&count, open.data() + 80, 4);
    --count;
    std::memcpy(open.data() + 80, &count, 4);
    fault(open.substr(0, 84 + 50 * count), container, "the surface is open");
    fault(bytes + bytes, container, "bytes follow the");
    // In the bounding box of the cylinder, but beyond its wall.
    Packing corner{.container = parse_container("box:0.03,0.03,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    corner.bodies.push_back({.shape = 0, .position_m = Vec3(0.009, 0.009, 0.02)});
    write_packing(folder.path() / "corner.json", corner);
    ASSERT_EQ(porepack("stl --output " + quoted(folder.path() / "corner") + " " + quoted(folder.path() / "corner.json")).exit_code, 0);
    fault(read_text(folder.path() / "corner" / "solid.stl"), container, "through the wall of the container");
    EXPECT_TRUE(has(porepack("voxelise --container cylinder:1,1 " + quoted(folder.path())).err, "cannot tell what"));
    EXPECT_TRUE(has(porepack("voxelise --section 0.005,0.025 " + container + " " + quoted(folder.path() / "solid.stl")).err,
                    "voxel size is missing"));
}

TEST(Blocked, DoesNotPercolate) {
    const test::Folder folder;
    Packing packing{
        .container = parse_container("cylinder:0.03,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.05, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0, 0, 0.03)});
    packing.overlap_allowed = true;
    write_packing(folder.path() / "packing.json", packing);
    const auto output = porepack("lbm --voxel-size 1e-3 --grids 1 --section 0.01,0.05 " + quoted(folder.path() / "packing.json"));
    EXPECT_EQ(output.exit_code, 3);
    EXPECT_TRUE(has(output.err, "does not percolate"));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "flow.vti"));
}

TEST(Engines, AMissingOneHasItsMessage) {
    const test::Folder folder;
    folder.write("case.toml", head + "[packing]\nengine = \"liggghts\"\ngrains = 2\n");
    const auto pack = porepack("pack " + quoted(folder.path()), "PATH=/nowhere");
    EXPECT_EQ(pack.exit_code, 4);
    EXPECT_TRUE(has(pack.err, "liggghts is not installed"));
    EXPECT_TRUE(has(pack.err, "apt-get install"));
    EXPECT_TRUE(has(porepack("status " + quoted(folder.path())).out, "failed"));
    write_spheres(folder.path() / "packing.json");
    const auto foam = porepack("foam --cell-size 2e-3 --section 0.01,0.02 " + quoted(folder.path() / "packing.json"), "PATH=/nowhere");
    EXPECT_EQ(foam.exit_code, 4);
    EXPECT_TRUE(has(foam.err, "blockMesh is not installed"));
}

// A template that fails, one that ends early with code 0, and an engine that is killed: all detected, with the tail of the log.
TEST(Engines, AFailingOneShowsItsLog) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    folder.write("case.toml", head + "[packing]\nengine = \"liggghts\"\ngrains = 2\n");
    const auto with_template = [&](const std::string& text) {
        std::filesystem::create_directories(folder.path() / "home");
        std::filesystem::copy(Path(POREPACK_SOURCE_FOLDER) / "liggghts_templates", folder.path() / "home/liggghts_templates",
                              std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
        folder.write("home/liggghts_templates/pour.in", text);
        return porepack("pack " + quoted(folder.path()), "POREPACK_HOME=" + quoted(folder.path() / "home"));
    };
    const auto failing = with_template("no_such_command\n");
    EXPECT_EQ(failing.exit_code, 4);
    EXPECT_TRUE(has(failing.err, "no_such_command"));
    const auto early = with_template("print \"all is well\"\n");
    EXPECT_EQ(early.exit_code, 4);
    EXPECT_TRUE(has(early.err, "before the end of its script"));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "results/pack"));
    const auto killed = with_template("shell sh -c 'kill -9 $PPID'\nprint \"unreachable\"\n");
    EXPECT_EQ(killed.exit_code, 4);
}

TEST(Disk, FullOrForbiddenLeavesNothing) {
    const test::Folder folder;
    write_spheres(folder.path() / "packing.json", 0.001);
    // A limit on the file size simulates a full disk: the write fails in the middle.
    const auto full = porepack("stl " + quoted(folder.path() / "packing.json"), "ulimit -f 8;");
    EXPECT_EQ(full.exit_code, 5) << full.err;
    EXPECT_TRUE(has(full.err, "cannot write"));
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) files += entry.path().filename() == "packing.json" ? 0 : 1;
    EXPECT_EQ(files, 0);
    const auto flow = porepack("voxelise --voxel-size 2e-4 --section 0.0,0.03 " + quoted(folder.path() / "packing.json"), "ulimit -f 8;");
    EXPECT_EQ(flow.exit_code, 5) << flow.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "pore.vti"));
    const auto forbidden = porepack("stl --output /proc/porepack " + quoted(folder.path() / "packing.json"));
    EXPECT_EQ(forbidden.exit_code, 2) << forbidden.err;
    EXPECT_TRUE(has(forbidden.err, "cannot make the folder"));
}

TEST(Interrupt, EndsEverySlowStageWithFive) {
    const test::Folder folder;
    Packing packing{
        .container = parse_container("cylinder:0.03,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    for (int i = 0; i < 5; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.004 * (i % 2), 0.0, 0.005 + 0.0105 * i)});
    write_packing(folder.path() / "packing.json", packing);
    std::vector<std::string> calls = {"lbm --grids 1 --voxel-size 2e-4 --iteration-tolerance 1e-10 --section 0.005,0.045",
                                      "tortuosity geometric_paper --dot-spacing 1e-4 --slice-spacing 1e-5 --section 0.005,0.045",
                                      "slices --spacing 2e-6 --pixel 1e-4 --section 0.005,0.045"};
    if (find_program("simpleFoam")) calls.push_back("foam --cell-size 4e-4 --section 0.005,0.045");
    for (const auto& call : calls) {
        const auto output = porepack(call + " " + quoted(folder.path() / "packing.json"), "timeout -s INT 1");
        EXPECT_TRUE(has(output.err, "interrupted")) << call;
        EXPECT_TRUE(output.exit_code == 5 || output.exit_code == 124) << call << output.exit_code;
        int files = 0;
        for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
            files += entry.path().filename() == "packing.json" ? 0 : 1;
        // Only the files from which a run resumes are left.
        const auto left =
            std::filesystem::remove(folder.path() / "lbm.checkpoint") || std::filesystem::remove_all(folder.path() / ".foam.running") > 0;
        EXPECT_EQ(files, left ? 1 : 0) << call;
    }
}

}  // namespace
}  // namespace porepack
