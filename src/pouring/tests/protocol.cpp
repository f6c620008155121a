// What is done to a bed after the pour, against exact answers.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "pouring/dem/protocol_run.hpp"
#include "support/helpers.hpp"
#include "support/pours.hpp"
#include "vessels/config.hpp"

namespace porepack::test {
namespace {

using pouring::dem::pour_with_capsules;
using pouring::dem::ProtocolRun;

// A ball on a plate at a (1 - cos w t) leaves it when the plate's acceleration is -g; then it flies, and rebounds without loss.
struct BouncingBall {
    double amplitude, omega, g;
    [[nodiscard]] double plate(double t) const { return amplitude * (1.0 - std::cos(omega * t)); }
    [[nodiscard]] double plate_speed(double t) const { return amplitude * omega * std::sin(omega * t); }
    // Height above the plate at the given times, up to the third impact, and the times of the impacts.
    std::vector<double> heights(const std::vector<double>& times, std::vector<double>& impacts) const {
        double start = std::acos(-g / (amplitude * omega * omega)) / omega, z = plate(start), v = plate_speed(start);
        std::vector<double> found;
        const auto above = [&](double t) { return z + v * (t - start) - 0.5 * g * (t - start) * (t - start) - plate(t); };
        const auto next_impact = [&] {
            const double step = 1e-3 / omega;
            double t = start + 50.0 * step;
            while (above(t) > 0.0) t += step;
            double low = t - step, high = t;
            for (int n = 0; n < 60; ++n) (above(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
            return high;
        };
        double impact = next_impact();
        for (const double t : times) {
            while (t > impact && impacts.size() < 3) {
                impacts.push_back(impact);
                const double relative = v - g * (impact - start) - plate_speed(impact);
                z = plate(impact);
                v = plate_speed(impact) - relative;
                start = impact;
                impact = next_impact();
            }
            if (impacts.size() == 3) break;
            found.push_back(t < start ? 0.0 : above(t));
        }
        return found;
    }
};

TEST(Protocol, ABallOnAVibratingPlateBouncesAsItShould) {
    const double d = 0.01, frequency = 20.0, g = 9.81, acceleration = 2.2 * g;
    const BouncingBall exact{acceleration / std::pow(2.0 * std::numbers::pi * frequency, 2), 2.0 * std::numbers::pi * frequency, g};
    std::vector<double> errors;
    for (const double stiffness : {1.6e5, 2.56e6, 4.1e7}) {
        const PackingConfig config{
            .normal_stiffness_N_per_m = stiffness, .tangential_stiffness_N_per_m = 0.5 * stiffness, .normal_damping = 0.0, .sleep = false};
        const Container container = parse_container("cylinder:0.05,0.2");
        const Shape ball = make_preset(ShapeKind::sphere, d, 0.0);
        const ContactTimes times = contact_times(config.density_kg_per_m3 * measure(ball, 1e-6).volume_m3,
                                                 config.density_kg_per_m3 * measure(ball, 1e-6).volume_m3, d, 1, config);
        CapsuleDem dem(container, {ball}, config.density_kg_per_m3, contact_law(config), {.time_step_s = times.time_step_s});
        const double mass = dem.grain(0).mass_kg, rest = 0.5 * d - mass * g / (0.5 * stiffness);
        dem.add(0, Vec3(0.0, 0.0, rest), Quaternion::Identity());
        const ProtocolConfig protocol{
            .step = {{.kind = StepKind::vibrate, .peak_acceleration_m_per_s2 = acceleration, .frequency_Hz = frequency, .time_s = 0.5}}};
        ProtocolRun run(protocol, config,
                        {.plan = {.time_step_s = times.time_step_s, .contact_time_s = times.contact_time_s},
                         .diameter_m = d,
                         .feret_diameter_m = d,
                         .rest_limit_J = 1e-12},
                        dem);
        run.begin();
        std::vector<double> at, heights, impacts;
        while (dem.time_s() < 0.3) {
            run.advance();
            at.push_back(dem.time_s());
            heights.push_back(dem.centre_of_mass(0).z() - 0.5 * d);
        }
        const std::vector<double> expected = exact.heights(at, impacts);
        ASSERT_EQ(impacts.size(), 3U);
        ASSERT_GT(expected.size(), 20U);
        double worst = 0.0;
        for (std::size_t n = 0; n < expected.size(); ++n) worst = std::max(worst, std::abs(heights[n] - expected[n]));
        errors.push_back(worst / *std::max_element(expected.begin(), expected.end()));
    }
    // A contact lasts for a time that falls with the root of the stiffness, and so does the error; each rebound makes it larger.
    std::printf("  largest error up to the third impact over the largest height: %.3f, %.3f, %.3f\n", errors[0], errors[1], errors[2]);
    EXPECT_LT(errors[2], 0.06);
    EXPECT_LT(errors[2], 0.35 * errors[1]);
    EXPECT_LT(errors[1], 0.35 * errors[0]);
}

TEST(Protocol, ALidsWeightArrivesAtFloorAndSides) {
    const Folder folder;
    const PackingConfig config{.fill = Fill::lattice, .grains = 60, .density_kg_per_m3 = 2000.0, .wall_friction = 0.4};
    const ProtocolConfig protocol{.step = {{.kind = StepKind::lid, .mass_kg = 0.5, .stays = true}}};
    const Shape shape = make_preset(ShapeKind::sphere, 0.008, 0.0);
    const PourResult bed = pour_with_capsules(one(shape), parse_container("cylinder:0.03,0.3"), config, folder.path() / "run", protocol);
    const double g = config.gravity_m_per_s2, lid = 0.5 * g, grains = 60.0 * 2000.0 * measure(shape, 1e-6).volume_m3 * g;
    EXPECT_NEAR(*bed.lid_force_N, lid, 0.005 * lid);
    EXPECT_NEAR(-(*bed.floor_force_N + *bed.side_force_N), grains + lid, 0.01 * (grains + lid));
    EXPECT_LT(*bed.side_force_N, -0.05 * lid);
    ASSERT_EQ(bed.protocol.size(), 2U);
    EXPECT_LT(bed.protocol[1].bed_height_m, bed.protocol[0].bed_height_m);
    EXPECT_NEAR(bed.protocol[1].lid_height_m, bed.protocol[1].bed_height_m, 5e-4);  // the overlap
}

// Grains with faces, and a lid that falls with the vessel: without the tap's velocity the bed would fly up to it.
TEST(Protocol, ALidStaysOnGrainsWithFacesThatAreTapped) {
    const Folder folder;
    const PackingConfig config{.fill = Fill::lattice, .grains = 6, .density_kg_per_m3 = 2000.0, .settle_time_s = 1.0};
    const ProtocolConfig protocol{
        .step = {{.kind = StepKind::lid, .mass_kg = 0.05, .stays = true}, {.kind = StepKind::tap, .height_m = 0.002}}};
    const Shape shape = make_shape({.kind = ShapeKind::cylinder, .diameter_m = 0.01, .height_m = 0.01});
    const PourResult bed = pour_with_capsules(one(shape), parse_container("cylinder:0.03,0.15"), config, folder.path() / "run", protocol);
    const double weight = (0.05 + 6.0 * 2000.0 * measure(shape, 1e-6).volume_m3) * config.gravity_m_per_s2;
    EXPECT_NEAR(-(*bed.floor_force_N + *bed.side_force_N), weight, 0.01 * weight);
    ASSERT_EQ(bed.protocol.size(), 3U);
    EXPECT_NEAR(bed.protocol[2].lid_height_m, bed.protocol[2].bed_height_m, 2e-4);
}

TEST(Protocol, APlateStopsAtAHeightAPressureOrAPorosity) {
    const Folder folder;
    const PackingConfig config{.fill = Fill::lattice, .grains = 40};
    const Container tube = parse_container("cylinder:0.06,0.6");
    const auto shape = one(make_preset(ShapeKind::tetrapod, 0.008, 0.008));
    const auto compressed = [&](const char* name, const ProtocolStep& step) {
        return pour_with_capsules(shape, tube, config, folder.path() / name, {.step = {step}}).protocol;
    };
    const double height = 0.97 * compressed("poured", {.kind = StepKind::settle})[0].bed_height_m;
    const auto to_height = compressed("height", {.kind = StepKind::compress, .to_height_m = height, .stays = true});
    EXPECT_NEAR(to_height[1].lid_height_m, height, 1e-6);
    EXPECT_LT(to_height[1].bed_height_m, height + 5e-4);  // with the overlap
    EXPECT_LT(to_height[1].porosity, to_height[0].porosity);
    const auto to_pressure = compressed("pressure", {.kind = StepKind::compress, .pressure_Pa = 500.0, .stays = true});
    EXPECT_NEAR(to_pressure[1].pressure_Pa, 500.0, 1.0);
    const double aim = to_height[0].porosity - 0.01;
    const auto to_porosity = compressed("porosity", {.kind = StepKind::compress, .to_porosity = aim, .stays = true});
    EXPECT_TRUE(to_porosity[1].reached);
    EXPECT_NEAR(to_porosity[1].porosity, aim, 0.004);
    // Out of reach: the step ends, and says so.
    const auto never = compressed("never", {.kind = StepKind::compress, .to_porosity = 0.1, .speed_m_per_s = 0.2});
    EXPECT_FALSE(never[1].reached);
}

TEST(Protocol, TapsMakeABedDenser) {
    const Folder folder;
    const PackingConfig config{.fill = Fill::lattice, .grains = 30};
    const auto shape = one(make_preset(ShapeKind::tetrapod, 0.008, 0.008));
    const ProtocolConfig protocol{.target_porosity = 0.3, .step = {{.kind = StepKind::tap, .number = 6, .height_m = 0.004}}};
    const PourResult bed = pour_with_capsules(shape, parse_container("cylinder:0.06,0.6"), config, folder.path() / "run", protocol);
    ASSERT_EQ(bed.protocol.size(), 7U);
    EXPECT_LT(bed.protocol.back().porosity, bed.protocol.front().porosity - 0.005);
    EXPECT_FALSE(bed.protocol.back().reached);
    EXPECT_TRUE(bed.at_rest());
    const ProtocolConfig near{.target_porosity = bed.protocol[2].porosity,
                              .step = {{.kind = StepKind::tap, .number = 100, .height_m = 0.004}}};
    const PourResult ended = pour_with_capsules(shape, parse_container("cylinder:0.06,0.6"), config, folder.path() / "near", near);
    EXPECT_TRUE(ended.protocol.back().reached);
    EXPECT_LE(ended.protocol.size(), 3U);
}

// Stopped again and again, the steps give the same bits.
TEST(Protocol, StoppedAtEveryCheckGivesTheSameBits) {
    const Folder folder;
    const Container tube = parse_container("cylinder:0.06,0.4");
    const auto shape = one(make_preset(ShapeKind::tetrapod, 0.008, 0.008));
    const ProtocolConfig protocol{.step = {{.kind = StepKind::settle},
                                           {.kind = StepKind::tap, .number = 2, .height_m = 0.001},
                                           {.kind = StepKind::vibrate, .frequency_Hz = 100.0, .amplitude_m = 1e-4, .time_s = 0.06},
                                           {.kind = StepKind::lid, .mass_kg = 0.02},
                                           {.kind = StepKind::settle}}};
    const auto poured = [&](const char* name, double snapshot_interval_s) {
        const PackingConfig config{.fill = Fill::lattice, .grains = 12, .snapshot_interval_s = snapshot_interval_s};
        return pour_with_capsules(shape, tube, config, folder.path() / name, protocol);
    };
    const PourResult whole = poured("whole", 1e9);
    long calls = -1, stops = 0;  // counted from the first step on
    const Context stopping{.log =
                               [&](LogLevel, std::string_view text) {
                                   if (has(std::string(text), "resumes from") || has(std::string(text), "at most")) calls = 0;
                               },
                           .progress = {},
                           .interrupted = [&] { return calls >= 0 && ++calls > 8; }};
    const core::ContextScope scope(stopping);
    std::optional<PourResult> stopped;
    while (!stopped.has_value() && stops < 500) {
        calls = -1;
        try {
            stopped = poured("stopped", 1e-9);
        } catch (const MachineError&) {
            ++stops;
        }
    }
    ASSERT_TRUE(stopped.has_value());
    EXPECT_GT(stops, 5);
    EXPECT_EQ(stopped->steps, whole.steps);
    const auto shaken = [](const ProtocolRow& row) { return row.kind == StepKind::vibrate; };
    EXPECT_EQ(std::count_if(whole.protocol.begin(), whole.protocol.end(), shaken), 4);  // a row per 500 steps, the last one at rest
    ASSERT_EQ(stopped->protocol.size(), whole.protocol.size());
    EXPECT_EQ(stopped->protocol.back().porosity, whole.protocol.back().porosity);
    for (std::size_t i = 0; i < whole.packing.bodies.size(); ++i)
        EXPECT_EQ(stopped->packing.bodies[i].position_m, whole.packing.bodies[i].position_m) << i;
}

// Without friction spheres jam where each has six contacts: as many as it has ways to move, twice.
TEST(Protocol, FrictionlessSpheresWithoutWallsJamWithSixContacts) {
    const Folder folder;
    const PackingConfig config{.fill = Fill::scatter, .grains = 120};
    const ProtocolConfig protocol{.step = {{.kind = StepKind::compress, .pressure_Pa = 500.0, .friction = 0.0}}};
    const Container box = make_box({0.1, 0.1, 0.1}, {true, true, true});
    const PourResult bed = pour_with_capsules(one(make_preset(ShapeKind::sphere, 0.01, 0.0)), box, config, folder.path() / "run", protocol);
    ASSERT_EQ(bed.protocol.size(), 1U);
    const ProtocolRow& row = bed.protocol[0];
    EXPECT_TRUE(row.reached);
    EXPECT_NEAR(row.pressure_Pa, 500.0, 1.0);
    std::printf("  porosity %.4f, %.2f contacts, %ld rattlers\n", row.porosity, *row.coordination_without_rattlers, *row.rattlers);
    // 500 spheres, five seeds (docs/packing.md): 0.360 and 5.95 + 0.0177 sqrt(500) at this pressure; 100 spheres differ from them by 0.007.
    EXPECT_NEAR(row.porosity, 0.360, 0.014);
    EXPECT_NEAR(*row.coordination_without_rattlers, 6.35, 0.2);
    EXPECT_LT(*row.rattlers, 12);
    const Vec3 size = bed.packing.container.size();
    EXPECT_NEAR(1.0 - 120.0 * measure(bed.packing.shapes[0], 1e-6).volume_m3 / size.prod(), row.porosity, 0.01);
}

// Above the jammed porosity nothing holds the spheres: they lie apart, or touch, and do not move.
TEST(Protocol, ALooseBedWithoutWallsHasThePorosity) {
    const Folder folder;
    const PackingConfig config{.fill = Fill::scatter, .grains = 60};
    const Container box = make_box({0.09, 0.09, 0.09}, {true, true, true});
    for (const double aim : {0.55, 0.42}) {
        const ProtocolConfig protocol{.step = {{.kind = StepKind::compress, .to_porosity = aim, .friction = 0.0}}};
        const PourResult bed =
            pour_with_capsules(one(make_preset(ShapeKind::sphere, 0.01, 0.0)), box, config, folder.path() / "run", protocol);
        EXPECT_TRUE(bed.protocol.at(0).reached);
        EXPECT_NEAR(bed.protocol.at(0).porosity, aim, 1e-3);  // 10,000 lines
        EXPECT_LT(find_overlaps(bed.packing).largest_between_grains_m, 1e-5);
    }
}

TEST(Protocol, BadStepsAreNamed) {
    const Folder folder;
    const auto shape = one(make_preset(ShapeKind::tetrapod, 0.008, 0.008));
    const auto message = [&](const ProtocolConfig& protocol, const char* container, PackingConfig config) {
        return message_of<UserError>(
            [&] { (void)pour_with_capsules(shape, parse_container(container), config, folder.path() / "run", protocol); });
    };
    const PackingConfig few{.fill = Fill::lattice, .grains = 5};
    const char* tube = "cylinder:0.06,0.4";
    const auto refuses = [&](const ProtocolStep& step, const char* part, const char* container = "cylinder:0.06,0.4") {
        const std::string text = message({.step = {step}}, container, few);
        EXPECT_TRUE(has(text, part)) << text;
        EXPECT_TRUE(has(text, "step 1")) << text;
    };
    refuses({.kind = StepKind::tap, .number = 3}, "a tap needs its strength");
    refuses({.kind = StepKind::tap, .height_m = 0.001, .mass_kg = 1.0}, "`mass_kg` has no effect");
    refuses({.kind = StepKind::vibrate, .amplitude_m = 0.001}, "vibration needs");
    refuses({.kind = StepKind::vibrate, .peak_acceleration_m_per_s2 = 1e4, .frequency_Hz = 1.0, .time_s = 1.0}, "pass through each other");
    refuses({.kind = StepKind::vibrate, .frequency_Hz = 1e5, .amplitude_m = 1e-6, .time_s = 1.0}, "is too short");
    refuses({.kind = StepKind::lid}, "a lid needs its weight");
    refuses({.kind = StepKind::lid, .mass_kg = 1e-5}, "heavier than a grain");
    refuses({.kind = StepKind::lid, .mass_kg = 1.0}, "same at all heights", "cone:0.06,0.07,0.4");
    refuses({.kind = StepKind::compress, .pressure_Pa = 1e7}, "press grains into each other");
    refuses({.kind = StepKind::compress, .to_height_m = 0.39}, "would not touch the bed");
    refuses({.kind = StepKind::compress, .to_height_m = 0.1, .to_porosity = 0.4}, "compression needs its end");
    EXPECT_TRUE(has(message({.target_porosity = 0.4, .step = {{}}}, tube, few), "needs taps or vibration"));
    EXPECT_TRUE(has(message({}, tube, {.fill = Fill::scatter, .grains = 5}), "a box without walls"));
    // Too many for a box without contact: the message says how large it must be.
    const ProtocolConfig pressed{.step = {{.kind = StepKind::compress, .pressure_Pa = 100.0}}};
    const auto crowded = [&] {
        (void)pour_with_capsules(shape, make_box({0.06, 0.06, 0.06}, {true, true, true}), {.fill = Fill::scatter, .grains = 90},
                                 folder.path() / "run", pressed);
    };
    EXPECT_TRUE(has(message_of<UserError>(crowded), "do not fit into the box without contact"));
}

}  // namespace
}  // namespace porepack::test
