// Pours by LIGGGHTS: what follows the pour, grains with faces, other vessels, and what it cannot do.
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

}  // namespace
}  // namespace porepack
