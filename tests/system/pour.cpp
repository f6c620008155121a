// Pours by the capsule engine: protocol, difficult cases, a killed run, and both engines on the same task.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/context.hpp"
#include "packing/grains.hpp"
#include "packing/porosity.hpp"
#include "pouring/batches.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "pouring/liggghts/liggghts.hpp"
#include "record/digest.hpp"
#include "shapes/rounded_body.hpp"
#include "support/helpers.hpp"
#include "support/pours.hpp"
#include "support/stones.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has, test::one, test::paper_shape, test::expect_sound;

PourResult pour(const Shape& shape, const char* container, PackingConfig config, const test::Folder& folder) {
    return pour_with_capsules(one(shape), parse_container(container), config, folder.path() / "run");
}

TEST(Pour, HardCasesComeToRest) {
    const test::Folder folder;
    const auto run = [&](const char* name, const Shape& shape, const char* container, PackingConfig config, double overlap = 0.02) {
        const PourResult result = pour_with_capsules(one(shape), parse_container(container), config, folder.path() / name);
        std::printf("  %s: %ld grains, %ld steps, %.1f s\n", name, result.grains, result.steps, result.wall_time_s);
        expect_sound(result, overlap);
        return result;
    };
    run("one grain", paper_shape(ShapeKind::tetrapod, 0.53), "cylinder:0.05,0.15", {.grains = 1});
    run("two grains", paper_shape(ShapeKind::tetrapod, 0.53), "cylinder:0.05,0.15", {.grains = 2});
    run("needle tetrapods", paper_shape(ShapeKind::tetrapod, 0.43), "cylinder:0.07,0.4", {.grains = 20, .batch_grains = 4});
    run("needle dolosse, dropped from 1 m", paper_shape(ShapeKind::dolos, 0.43), "cylinder:0.08,1.1", {.grains = 15, .batch_grains = 4},
        0.05);
    run("tetrahedra", paper_shape(ShapeKind::tetrahedron, 0.81), "cylinder:0.05,0.2", {.grains = 30, .batch_grains = 4});
    // Without friction a bed in a cylinder may rotate about the axis without end.
    run("no friction", paper_shape(ShapeKind::tetrapod, 0.81), "box:0.045,0.045,0.25",
        {.grains = 30, .friction = 0.0, .wall_friction = 0.0, .rest_energy_fraction = 1e-4, .settle_time_s = 10.0});
    run("no restitution", paper_shape(ShapeKind::tetrapod, 0.81), "cylinder:0.05,0.2",
        {.grains = 30, .normal_damping = 0.99, .tangential_damping = 0.9});
    run("a grain as wide as the container", paper_shape(ShapeKind::tetrapod, 0.53), "cylinder:0.0335,0.2",
        {.grains = 5, .batch_grains = 1});
    run("from a lattice, in a box", paper_shape(ShapeKind::tetrapod, 0.81), "box:0.07,0.07,0.3", {.fill = Fill::lattice, .grains = 40});
    PackingConfig stiff{.grains = 10, .normal_stiffness_N_per_m = 1e6, .tangential_stiffness_N_per_m = 5e5, .time_step_s = 2e-5};
    EXPECT_TRUE(
        has(test::message_of<UserError>([&] { (void)pour(paper_shape(ShapeKind::tetrapod, 0.81), "cylinder:0.05,0.2", stiff, folder); }),
            "too long"));
}

// A packing does not depend on the machine, the build type or the order of linking: core, shapes, packing and pour are compiled without
// contraction of a*b + c. If a change of the engine is meant to change packings, replace the digest and raise the stage's result_version.
TEST(Pour, ASmallPackingHasTheSameBytesEverywhere) {
    const test::Folder folder;
    const PourResult result =
        pour(paper_shape(ShapeKind::tetrapod, 0.53), "cylinder:0.05,0.2", {.seed = 1, .grains = 12, .batch_grains = 2}, folder);
    write_packing(folder.path() / "packing.json", result.packing);
    EXPECT_EQ(sha256_of_file(folder.path() / "packing.json"), "b142d3508919dc1f0b7ad82aadd34c067e9dc462f95de99c25ff8c41e57570d7");
}

TEST(Pour, PeriodicSidesAndMixtures) {
    const test::Folder folder;
    const Container box = vessels::make_box({0.07, 0.07, 0.25}, {true, true, false});
    std::vector<ShapeShare> mixture = {{.shape = paper_shape(ShapeKind::tetrapod, 0.81), .number_fraction = 0.5},
                                       {.shape = paper_shape(ShapeKind::sphere, 1.0), .number_fraction = 0.5}};
    const PourResult result = pour_with_capsules(mixture, box, {.fill = Fill::lattice, .grains = 60}, folder.path() / "run");
    expect_sound(result);
    EXPECT_EQ(result.grains, 60);
    for (const Body& body : result.packing.bodies)
        for (const int axis : {0, 1}) {
            EXPECT_GE(body.position_m[axis], 0.0);
            EXPECT_LE(body.position_m[axis], 0.07);
        }
    // At least one grain crosses a face, else the faces were walls.
    bool across = false;
    for (const Body& body : result.packing.bodies) {
        const Bounds bounds = bounds_of(world_capsules(result.packing, body));
        across = across || bounds.low.x() < -0.001 || bounds.high.x() > 0.071;
    }
    EXPECT_TRUE(across);
    const Container closed = vessels::make_box(box.size(), {true, true, true});
    EXPECT_TRUE(has(test::message_of<UserError>([&] { (void)pour_with_capsules(mixture, closed, {.grains = 5}, folder.path() / "z"); }),
                    "cannot be periodic"));
}

// Beds of spheres in cylinders of 9 diameters are known to have porosities of 0.38 to 0.42.
TEST(Pour, SpheresInACylinderOfNineDiameters) {
    const test::Folder folder;
    const Shape sphere = paper_shape(ShapeKind::sphere, 1.0);
    const double d = smallest_diameter(sphere);
    const PourResult result =
        pour(sphere, ("cylinder:" + std::to_string(9.0 * d) + ",0.5").c_str(), {.grains = 600, .batch_grains = 60}, folder);
    const Grains grains(result.packing);
    const double value = porosity(grains, result.packing.container, {d, grains.bounds().high.z() - d}, 20000).value;
    std::printf("  porosity %.4f, coordination number %.2f, %.1f s\n", value, *result.coordination_number, result.wall_time_s);
    EXPECT_GT(value, 0.38);
    EXPECT_LT(value, 0.42);
}

TEST(Pour, AllAxesParallel) {
    // Equal rods on a lattice, all along y, dropped: contacts of exactly parallel axes everywhere.
    const Shape rod = make_preset(ShapeKind::rod, 0.01, 0.02);
    CapsuleDem dem(parse_container("box:0.0515,0.04,0.2"), {rod}, 1000.0, {}, {.time_step_s = 2e-5});
    const Quaternion turn = Quaternion::FromTwoVectors(Vec3(rod.capsules[0].b - rod.capsules[0].a), Vec3(Vec3::UnitY()));
    for (int i = 0; i < 20; ++i) dem.add(0, Vec3(0.0055 + 0.0101 * (i % 5), 0.02, 0.006 + 0.012 * (i / 5)), turn);
    dem.step(40000);
    const DemRest rest = dem.rest();
    EXPECT_LT(rest.kinetic_energy_per_grain_J, 1e-6 * dem.grain(0).mass_kg * 9.81 * 0.01);
    EXPECT_LT(rest.largest_overlap_m, 1e-4);
    for (std::size_t i = 0; i < dem.size(); ++i) EXPECT_GT(std::abs((dem.pose(i).orientation * turn.conjugate()).w()), 0.999) << i;
}

TEST(Pour, CreatedOverlapping) {
    const Shape tetrapod = paper_shape(ShapeKind::tetrapod, 0.81);
    CapsuleDem dem(parse_container("cylinder:0.1,0.5"), {tetrapod}, 1000.0, {}, {.time_step_s = 1e-5});
    for (int i = 0; i < 4; ++i) dem.add(0, Vec3(0.002 * i, 0.0, 0.02 + 0.001 * i), Quaternion::Identity());
    dem.step(100000);
    const DemRest rest = dem.rest();
    EXPECT_TRUE(std::isfinite(rest.kinetic_energy_per_grain_J));
    EXPECT_LT(rest.largest_overlap_m, 0.01 * 0.0065);
}

TEST(Pour, SleepersChangeNothingThatCounts) {
    // A pour is chaotic: with and without sleepers the grain positions differ, but the porosity is the same. Five seeds each.
    const test::Folder folder;
    const auto porosities = [&](bool sleep) {
        std::vector<double> values;
        for (long seed = 1; seed <= 5; ++seed) {
            const PourResult result = pour_with_capsules(one(paper_shape(ShapeKind::tetrapod, 0.81)), parse_container("cylinder:0.04,0.25"),
                                                         {.seed = seed, .grains = 70, .batch_grains = 6, .sleep = sleep},
                                                         folder.path() / (std::to_string(seed) + (sleep ? "s" : "a")));
            values.push_back(porosity(Grains(result.packing), result.packing.container, {0.01, 0.055}, 4000).value);
        }
        double mean = 0.0, squares = 0.0;
        for (const double value : values) mean += value / 5.0;
        for (const double value : values) squares += (value - mean) * (value - mean) / 4.0;
        return std::pair(mean, std::sqrt(squares / 5.0));
    };
    const auto [asleep, asleep_error] = porosities(true);
    const auto [awake, awake_error] = porosities(false);
    std::printf("  porosity %.4f +- %.4f with sleepers, %.4f +- %.4f without\n", asleep, asleep_error, awake, awake_error);
    EXPECT_NEAR(asleep, awake, 3.0 * std::hypot(asleep_error, awake_error));
}

// Killed as soon as a file of that name pattern exists, then resumed: the same bits as without interruption.
void expect_same_bits_after_a_kill(const std::string& engine, const std::string& snapshot) {
    const test::Folder folder;
    const std::string text =
        "[shape]\nkind = \"tetrapod\"\nsphericity = 0.81\nvolume_m3 = 7.33e-7\n[container]\nkind = \"cylinder\"\ndiameter_m = "
        "0.05\nheight_m = 0.2\n"
        "[packing]\nbatch_grains = 2\nsnapshot_interval_s = 0.2\n" +
        engine;
    folder.write("whole/case.toml", text);
    folder.write("killed/case.toml", text);
    ASSERT_EQ(test::porepack("pack " + test::quoted(folder.path() / "whole")).exit_code, 0);
    const std::string results = test::quoted(folder.path() / "killed" / "results");
    const Path watcher =
        folder.write("kill_at_snapshot", "\"$@\" &\npid=$!\nwhile kill -0 $pid 2>/dev/null; do\n  [ -z \"$(find " + results + " -name '" +
                                             snapshot + "' 2>/dev/null)\" ] || kill -9 $pid\n  sleep 0.02\ndone\n");
    (void)test::porepack("pack " + test::quoted(folder.path() / "killed"), "sh " + test::quoted(watcher));
    ASSERT_FALSE(std::filesystem::exists(folder.path() / "killed" / "results" / "pack")) << "not killed";
    const auto rest = test::porepack("pack " + test::quoted(folder.path() / "killed"));
    EXPECT_EQ(rest.exit_code, 0) << rest.err;
    EXPECT_TRUE(has(rest.err, "resumes from")) << rest.err;
    const Path packing = Path("results") / "pack" / "packing.json";
    EXPECT_EQ(sha256_of_file(folder.path() / "whole" / packing), sha256_of_file(folder.path() / "killed" / packing));
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path() / "killed" / "results"))
        EXPECT_FALSE(entry.path().filename().string().starts_with("snapshot.") && entry.path().extension() != ".in") << entry.path();
}

TEST(Pour, AKilledPourGoesOnWithTheSameBits) {
    expect_same_bits_after_a_kill("engine = \"capsule\"\ngrains = 60\n", "snapshot.bin");
}

// Grains with faces sleep and are woken several times: stopped after every second check, a pour gives the same bits.
TEST(Pour, FacedGrainsStoppedAtEveryCheckGiveTheSameBits) {
    const test::Folder folder;
    const auto shapes = one(make_shape({.kind = ShapeKind::cylinder, .diameter_m = 0.01, .height_m = 0.01}));
    const Container container = parse_container("cylinder:0.03,0.1");
    const auto poured = [&](const char* name, double snapshot_interval_s) {
        const PackingConfig config{.fill = Fill::lattice, .grains = 12, .snapshot_interval_s = snapshot_interval_s};
        return pour_with_capsules(shapes, container, config, folder.path() / name);
    };
    const PourResult whole = poured("whole", 1e9);
    long calls = 0, stops = 0;
    const Context stopping{.log = [](LogLevel, std::string_view) {}, .progress = {}, .interrupted = [&] { return ++calls % 2 == 0; }};
    const core::ContextScope scope(stopping);
    std::optional<PourResult> stopped;
    while (!stopped.has_value() && stops < 10000) {
        calls = 0;
        try {
            stopped = poured("stopped", 1e-9);
        } catch (const MachineError&) {
            ++stops;
        }
    }
    ASSERT_TRUE(stopped.has_value());
    EXPECT_GT(stops, 20);
    EXPECT_EQ(stopped->steps, whole.steps);
    EXPECT_EQ(stopped->coordination_number, whole.coordination_number);
    ASSERT_EQ(stopped->packing.bodies.size(), whole.packing.bodies.size());
    for (std::size_t i = 0; i < whole.packing.bodies.size(); ++i) {
        EXPECT_EQ(stopped->packing.bodies[i].position_m, whole.packing.bodies[i].position_m) << i;
        EXPECT_EQ(stopped->packing.bodies[i].orientation.coeffs(), whole.packing.bodies[i].orientation.coeffs()) << i;
    }
}

TEST(PourLiggghts, AKilledPourGoesOnWithTheSameBits) {
    REQUIRE_PROGRAM("liggghts");
    expect_same_bits_after_a_kill("engine = \"liggghts\"\ngrains = 16\n", "snapshot.[4-9].*");
}

TEST(PourLiggghts, KilledBetweenTapsItGoesOnWithTheSameBits) {
    REQUIRE_PROGRAM("liggghts");
    expect_same_bits_after_a_kill(
        "engine = \"liggghts\"\ngrains = 6\n[[protocol.step]]\nkind = \"tap\"\nnumber = 6\nheight_m = 0.003\n"
        "[[protocol.step]]\nkind = \"vibrate\"\nfrequency_Hz = 100\namplitude_m = 0.0001\ntime_s = 0.02\n"
        "[[protocol.step]]\nkind = \"tap\"\nheight_m = 0.001\n",
        "snapshot.*.*.*.*.0.[1-9]");
}

// The paper's packing at full size: the packing stored in the case is reproduced, except for rounding differences between machines.
TEST(PourLong, ThePapersPackingComesOutAgain) {
    const test::Folder folder;
    const Path source = Path(POREPACK_SOURCE_FOLDER) / "cases" / "paper_packing";
    folder.write("case.toml", read_text(source / "case.toml"));
    const auto run = test::porepack("pack --json " + test::quoted(folder.path()));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Packing kept = read_packing(source / "settled" / "tetrapod_053.json.gz");
    const Packing made = read_packing(folder.path() / "results" / "pack" / "packing.json");
    // From the floor to the highest point, as in the paper (Eq. 15).
    const auto porosity_of = [](const Packing& packing) {
        const Grains grains(packing);
        return porosity(grains, packing.container, {0.0, grains.bounds().high.z()}, 20000).value;
    };
    const double expected = porosity_of(kept), found = porosity_of(made);
    std::printf("  porosity %.4f, kept %.4f; %zu and %zu grains\n", found, expected, made.bodies.size(), kept.bodies.size());
    EXPECT_NEAR(found, expected, 0.015);
    EXPECT_NEAR(found, 0.70, 0.015);
}

}  // namespace
}  // namespace porepack
