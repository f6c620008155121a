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
#include "support/stones.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;

std::vector<ShapeShare> one(const Shape& shape) {
    return {{.shape = shape, .number_fraction = 1.0}};
}
Shape paper_shape(ShapeKind kind, double sphericity) {
    const Dimensions size = dimensions_for(kind, sphericity, 7.33e-7, Cavity::filled);
    return make_preset(kind, size.diameter_m, size.length_m);
}
PourResult pour(const Shape& shape, const char* container, PackingConfig config, const test::Folder& folder) {
    return pour_with_capsules(one(shape), parse_container(container), config, folder.path() / "run");
}
void expect_sound(const PourResult& result, double largest_overlap = 0.02) {
    const Overlaps overlaps = find_overlaps(result.packing);
    EXPECT_LT(overlaps.largest_between_grains_m, largest_overlap * finest_diameter(result.packing));
    EXPECT_LT(result.kinetic_energy_per_grain_J, result.rest_limit_J);
    EXPECT_LT(*result.mean_force_over_weight, 0.05);
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

// The steps of [protocol] by LIGGGHTS's own fixes: gravity that changes, a servo wall, a mesh that moves.
TEST(PourLiggghts, CarriesOutStepsAsTheOwnEngineDoes) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    const Shape ball = make_preset(ShapeKind::sphere, 0.008, 0.0);
    const Container container = parse_container("cylinder:0.035,0.12");
    PackingConfig config{.fill = Fill::lattice, .grains = 40, .normal_stiffness_N_per_m = 40000, .tangential_stiffness_N_per_m = 20000};
    const double height = 0.0245;
    const ProtocolConfig protocol{
        .step = {{.kind = StepKind::tap, .number = 3, .height_m = 0.003},
                 {.kind = StepKind::vibrate, .peak_acceleration_m_per_s2 = 30.0, .frequency_Hz = 60.0, .time_s = 0.1},
                 {.kind = StepKind::compress, .to_height_m = height},
                 {.kind = StepKind::lid, .mass_kg = 0.05, .stays = true}}};
    std::vector<PourResult> beds;
    for (const bool clumps : {false, true}) {
        config.engine = clumps ? Engine::liggghts : Engine::capsule;
        const Path run = folder.path() / (clumps ? "l" : "c");
        beds.push_back(clumps ? pour_with_liggghts(one(ball), container, config, Path(POREPACK_SOURCE_FOLDER) / "liggghts_templates", run,
                                                   {}, protocol)
                              : pour_with_capsules(one(ball), container, config, run, protocol));
        EXPECT_TRUE(beds.back().at_rest());
        for (const ProtocolRow& row : beds.back().protocol)
            std::printf("  step %ld, part %ld: height %.4f m, porosity %.4f, plate %.4f m, %.4f N\n", row.step, row.repeat,
                        row.bed_height_m, row.porosity, row.lid_height_m, row.lid_force_N);
        const auto& rows = beds.back().protocol;
        const auto of_step = [&](long step, long repeat) {
            return *std::find_if(rows.begin(), rows.end(),
                                 [&](const ProtocolRow& row) { return row.step == step && row.repeat == repeat; });
        };
        EXPECT_GT(std::abs(of_step(1, 1).porosity - of_step(0, 0).porosity), 1e-3);  // the tap moves the grains
        EXPECT_LT(of_step(2, 0).porosity, of_step(0, 0).porosity);
        EXPECT_NEAR(of_step(3, 0).lid_height_m, height, 1e-6);
        EXPECT_LT(of_step(3, 0).bed_height_m, height + 2e-4);
        EXPECT_NEAR(rows.back().lid_force_N, 0.05 * 9.81, 0.005 * 0.05 * 9.81);
        EXPECT_NEAR(rows.back().lid_height_m, rows.back().bed_height_m, 1e-4);
    }
    ASSERT_GT(beds[0].protocol.size(), 8U);
    EXPECT_NEAR(beds[0].protocol.back().porosity, beds[1].protocol.back().porosity, 0.05);  // one bed of each
    // What its fixes cannot do is named.
    const auto refuses = [&](const ProtocolConfig& steps, const char* part) {
        const std::string text = test::message_of<UserError>([&] { (void)plan_pour(one(ball), container, config, steps); });
        EXPECT_TRUE(has(text, part)) << text;
    };
    refuses({.step = {{.kind = StepKind::compress, .to_porosity = 0.4}}}, "`to_porosity`");
    refuses({.step = {{.kind = StepKind::compress, .pressure_Pa = 100.0, .friction = 0.1}}}, "`friction`");
    refuses({.step = {{.kind = StepKind::lid, .mass_kg = 0.05, .stays = true}, {.kind = StepKind::settle}}}, "a plate that stays");
    refuses({.target_porosity = 0.4, .step = {{.kind = StepKind::tap, .height_m = 0.001}}}, "`target_porosity`");
}

TEST(PourLiggghts, TakesGrainsWithFaces) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    std::vector<ShapeShare> shapes = {
        {.shape = {.id = "cube", .body = make_polyhedron(box_size({0.008, 0.008, 0.008}, 0.0002))}, .number_fraction = 0.5},
        {.shape = {.id = "stone", .body = make_polyhedron(test::stone(1, 0.3, 3, 0.02))->scaled(0.009)}, .number_fraction = 0.5}};
    const PackingConfig config{.engine = Engine::liggghts, .grains = 12, .clump_spheres = 20, .drop_height_m = 0.08, .batch_grains = 3};
    const PourResult poured = pour_with_liggghts(shapes, parse_container("cylinder:0.03,0.12"), config,
                                                 Path(POREPACK_SOURCE_FOLDER) / "liggghts_templates", folder.path() / "run");
    EXPECT_TRUE(poured.at_rest());
    ASSERT_EQ(poured.packing.bodies.size(), 12U);
    EXPECT_LT(*poured.pose_error_m, 1e-9);
    EXPECT_GT(*poured.coordination_number, 1.5);
    // The grains overlap by up to twice the clumps' error more than the spheres.
    double error = 0.0;
    for (const auto& share : shapes) error = std::max(error, clump_error(share.shape, clump_spheres_for(share.shape, config)));
    const Overlaps overlaps = find_overlaps(poured.packing);
    EXPECT_GT(overlaps.contacts, 12);
    EXPECT_LT(overlaps.largest_between_grains_m, 2.0 * error + *poured.largest_clump_overlap_m);
    EXPECT_LT(overlaps.largest_with_wall_m, error + 2e-4);
}

// Both engines, between the same walls: nothing is lost, nothing lies outside, and the beds are alike.
TEST(PourLiggghts, FillsAnnuliAndConesAsTheOwnEngineDoes) {
    REQUIRE_PROGRAM("liggghts");
    const test::Folder folder;
    const Shape ball = make_preset(ShapeKind::sphere, 0.006, 0.0);
    for (const char* form : {"annulus:0.016,0.044,0.1", "cone:0.024,0.06,0.06"}) {
        const Container container = parse_container(form);
        // LIGGGHTS checks a cone's facets one by one: few grains.
        const std::size_t grains = form[0] == 'c' ? 40 : 120;
        PackingConfig config{.fill = Fill::lattice, .grains = static_cast<long>(grains)};
        double porosities[2];
        for (const bool clumps : {false, true}) {
            config.engine = clumps ? Engine::liggghts : Engine::capsule;
            const Path run = folder.path() / (std::string(form).substr(0, 9) + (clumps ? "l" : "c"));
            const PourResult poured =
                clumps ? pour_with_liggghts(one(ball), container, config, Path(POREPACK_SOURCE_FOLDER) / "liggghts_templates", run)
                       : pour_with_capsules(one(ball), container, config, run);
            ASSERT_EQ(poured.packing.bodies.size(), grains) << form;
            EXPECT_LT(find_overlaps(poured.packing).largest_with_wall_m, 1e-4) << form;
            const Grains solid(poured.packing);
            porosities[clumps ? 1 : 0] = porosity(solid, container, {0.0, 0.012}, 10000).value;
        }
        std::printf("  %s: porosity %.3f, LIGGGHTS %.3f\n", form, porosities[0], porosities[1]);
        EXPECT_NEAR(porosities[0], porosities[1], 0.03) << form;  // one bed of each
    }
}

// Runs LIGGGHTS itself, with one line of its script replaced.
std::string liggghts_fault(const std::string& line, const std::string& replacement, PackingConfig config = {}) {
    const test::Folder folder;
    const Path templates = folder.path() / "templates";
    std::filesystem::copy(Path(POREPACK_SOURCE_FOLDER) / "liggghts_templates", templates);
    std::string script = read_text(templates / "pour.in");
    const std::size_t at = script.find(line);
    EXPECT_NE(at, std::string::npos);
    write_text(templates / "pour.in", script.replace(at, line.size(), replacement));
    config.engine = Engine::liggghts;
    config.grains = 6;
    config.batch_grains = 2;
    config.surface_tolerance = 0.1;
    const auto pour = [&] {
        (void)pour_with_liggghts(one(paper_shape(ShapeKind::tetrapod, 0.81)), parse_container("cylinder:0.05,0.2"), config, templates,
                                 folder.path() / "run");
    };
    return test::message_of<Error>(pour);
}

TEST(PourLiggghts, WhatItDoesNotSayIsNamed) {
    REQUIRE_PROGRAM("liggghts");
    const auto expect_message = [](const std::string& message, const std::string& part) { EXPECT_TRUE(has(message, part)) << message; };
    // Time steps far too long: the grains gain energy until they leave the box, whichever is detected first.
    const std::string wild = liggghts_fault("timestep        ${time_step}", "variable long equal 20*${time_step}\ntimestep ${long}");
    EXPECT_TRUE(has(wild, "energy grows") || has(wild, "lost grains")) << wild;
    // A hole in the floor: grains fall out of the box.
    expect_message(liggghts_fault("include         walls_${container}.in", ""), "lost grains");
    expect_message(liggghts_fault("include         batch_${batch}.in", "if \"${batch} < 2\" then \"jump SELF on\"\nrun 1\nlabel on"),
                   "fell short");
    expect_message(liggghts_fault("print \"POREPACK done", "print \"POREPACK undone"), "before the end of its script");
    expect_message(liggghts_fault("fix motion", "fix motion", {.settle_time_s = 0.01}), "still decreases");
    expect_message(
        liggghts_fault("fix motion", "fix motion",
                       {.normal_damping = 0.0, .tangential_damping = 0.0, .friction = 0.0, .wall_friction = 0.0, .settle_time_s = 1.0}),
        "no longer decreases");
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
