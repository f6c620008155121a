// Falling-head curves that are hard to evaluate, or are none, and files with faults.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "falling_head/column.hpp"
#include "falling_head/falling_head.hpp"
#include "falling_head/least_squares.hpp"
#include "falling_head/paper_evaluation.hpp"
#include "support/helpers.hpp"
#include "support/level_curves.hpp"

namespace porepack {
namespace {

using test::frames;
using test::has;
using test::k_053;
using test::k_in_053;
using test::paper_053;
using test::simulated;

TEST(HardCurve, OrificeAloneAndDarcyAlone) {
    FallingHeadConfig config;
    // k -> infinity: k is bounded only from below, and near the value at which viscous loss would be visible.
    const auto orifice = fit_falling_head(std::vector{take_window(simulated({0.0, 1.0 / k_in_053}, config, 1e-3, 5), config)}, config);
    EXPECT_TRUE(std::isinf(orifice.permeability_interval_m2().high));
    EXPECT_TRUE(has(orifice.verdict(), "bounds k only from below"));
    EXPECT_NEAR(orifice.inverse_inertial_permeability_per_m.value * k_in_053, 1.0, 0.05);
    // k_in -> infinity: Darcy's law.
    FallingHeadConfig slow = config;
    slow.frames_per_s = 1.0;
    const auto darcy = fit_falling_head(std::vector{take_window(simulated({1e9, 0.0}, slow, 1e-3, 5, 60.0), slow)}, slow);
    EXPECT_NEAR(darcy.inverse_permeability_per_m2.value / 1e9, 1.0, 0.02);
    EXPECT_LE(darcy.inverse_inertial_permeability_per_m.interval.low, 0.0);
    EXPECT_TRUE(has(darcy.inertial_verdict(), "bounds k_in only from below"));
}

TEST(HardCurve, NoiseOfTenMillimetresGapsAndAJump) {
    FallingHeadConfig config;
    const LevelCurve noisy = take_window(simulated(paper_053, config, 1e-2, 2), config);
    const auto fit = fit_falling_head(std::vector{noisy}, config);
    EXPECT_NEAR(fit.noise_m, 1e-2, 2e-3);
    EXPECT_TRUE(has(fit.verdict(), "only from below")) << fit.verdict();
    LevelCurve gap = simulated(paper_053, config, 1e-4, 3);
    const auto drop = [&](double from, double to) {
        for (std::size_t i = gap.time_s.size(); i-- > 0;)
            if (gap.time_s[i] > from && gap.time_s[i] < to) {
                gap.time_s.erase(gap.time_s.begin() + static_cast<std::ptrdiff_t>(i));
                gap.level_m.erase(gap.level_m.begin() + static_cast<std::ptrdiff_t>(i));
            }
    };
    drop(1.5, 1.9);
    const LevelCurve with_gap = take_window(gap, config);
    ASSERT_EQ(with_gap.warnings.size(), 1U);
    EXPECT_TRUE(has(with_gap.warnings[0], "a gap of 0.4"));
    const auto over_gap = fit_falling_head(std::vector{with_gap}, config).inverse_permeability_per_m2;
    EXPECT_LE(over_gap.interval.low, 1.0 / k_053);
    EXPECT_GE(over_gap.interval.high, 1.0 / k_053);
    LevelCurve jump = simulated(paper_053, config, 1e-4, 3);
    for (std::size_t i = 100; i < jump.level_m.size(); ++i) jump.level_m[i] += 0.05;
    const LevelCurve with_jump = take_window(jump, config);
    ASSERT_EQ(with_jump.warnings.size(), 1U) << with_jump.warnings.size();
    EXPECT_TRUE(has(with_jump.warnings[0], "a jump of"));
    const auto over_jump = fit_falling_head(std::vector{with_jump}, config);
    EXPECT_GT(over_jump.residual_m, 10.0 * over_jump.noise_m);  // and the fit shows that the equation does not hold
}

TEST(HardCurve, WhatIsNoFallingHeadIsRefused) {
    const FallingHeadConfig config;
    const auto message = [&](std::vector<double> times, std::vector<double> levels) {
        return test::message_of<UserError>(
            [&] { (void)take_window({.name = "x.csv", .packing = {}, .time_s = std::move(times), .level_m = std::move(levels)}, config); });
    };
    EXPECT_TRUE(has(message({0, 1, 2, 3, 4, 5}, {0.2, 0.3, 0.4, 0.5, 0.6, 0.7}), "does not fall"));
    EXPECT_TRUE(has(message({0, 1, 2, 3, 4, 5}, {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}), "does not fall"));
    EXPECT_TRUE(has(message({0, 1}, {1.2, 0.2}), "too few"));
    EXPECT_TRUE(has(message({0, 1, 2, 3, 4, 5}, {-0.01, -0.02, -0.03, -0.04, -0.05, -0.06}), "below the top of the sample"));
    EXPECT_TRUE(has(message({0, 1, 2, 3, 4, 5}, {3.0, 2.9, 2.8, 2.7, 2.6, 2.5}), "no level lies in the window"));
    // Milliseconds read as seconds are too slow, millimetres read as metres out of range, seconds read as milliseconds too fast.
    EXPECT_TRUE(has(message({0, 1, 2, 3, 4, 5}, {1300, 1000, 700, 500, 300, 100}), "no level lies in the window"));
    const LevelCurve fast = take_window(
        {.name = "x.csv", .packing = {}, .time_s = {0, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3}, .level_m = {1.2, 1.0, 0.8, 0.6, 0.4, 0.2}}, config);
    ASSERT_GE(fast.warnings.size(), 1U);
    EXPECT_TRUE(has(fast.warnings[0], "faster than water falls freely"));
}

TEST(HardCurve, FilesWithFaultsAreNamedWithTheirLine) {
    const test::Folder folder;
    const auto message = [&](const std::string& text) {
        const Path file = folder.write("curve.csv", text);
        return test::message_of<UserError>([&] { (void)read_level_curve(file); });
    };
    EXPECT_TRUE(has(message("0,1\n1,0.9\n"), "does not name a time and a level"));
    EXPECT_TRUE(has(message("time_s,level_m\n0,1\n1,nan\n"), "curve.csv:3"));
    EXPECT_TRUE(has(message("time_s,level_m\n0,1\n1,\n"), "no number"));
    EXPECT_TRUE(has(message("time_s,level_m\n0,1\n2,0.9\n1,0.8\n"), "does not follow"));
    EXPECT_TRUE(has(message("time_s,level_m\n0,1\n1,0.9\n1,0.8\n"), "curve.csv:4"));
    EXPECT_TRUE(has(message("# nothing\n"), "no numbers"));
    const LevelCurve curve = read_level_curve(folder.write("good.csv", "# packing: A\r\ntime_ms; level_mm\r\n0; 1300\r\n20; 1290.5\r\n"));
    EXPECT_EQ(curve.packing, "A");
    EXPECT_DOUBLE_EQ(curve.time_s[1], 0.02);
    EXPECT_DOUBLE_EQ(curve.level_m[1], 1.2905);
    EXPECT_TRUE(has(message("time_s,level_m\n0,00,1,600\n"), "4 numbers where the header has 2"));
    EXPECT_TRUE(has(message("time_s;level_m\n0,0;1.599,6\n"), "no number"));
    EXPECT_TRUE(has(message("# packing: A\n# packing: B\n"), "one packing"));
    EXPECT_TRUE(has(message(std::string("\xFF\xFEt\0i\0", 6)), "UTF-16"));
    EXPECT_TRUE(has(message(std::string("a\0b", 3)), "not text"));
    EXPECT_LT(message(std::string(5000, 'x')).size(), 500U);
}

TEST(HardCurve, SpreadsheetsHabitsAreUnderstood) {
    const test::Folder folder;
    for (const char* text :
         {"time_ms;level_cm\n0,0;160\n20,0;159,05\n", "Time_ms\tLevel_cm\n0\t160,0\n20\t159,05\n",
          "\xEF\xBB\xBF\"time_s\",\"level_m\"\r\n0.00,1.6\r\n0.02,1.5905\r\n,,\r\n", "frame,level_m,time_s\r1,1.6,0\r2,1.5905,2e-2,\r"}) {
        const LevelCurve curve = read_level_curve(folder.write("curve.csv", text));
        ASSERT_EQ(curve.time_s.size(), 2U) << text;
        EXPECT_DOUBLE_EQ(curve.time_s[1], 0.02) << text;
        EXPECT_DOUBLE_EQ(curve.level_m[1], 1.5905) << text;
    }
}

TEST(HardCurve, TooLittleToTellIsSaid) {
    const LevelCurve curve{.name = "five", .packing = {}, .time_s = {0, 1, 2, 3, 4}, .level_m = {1.2, 0.9, 0.7, 0.55, 0.4}};
    const FallingHeadFit fit = fit_falling_head(std::span(&curve, 1), FallingHeadConfig{});
    // Rounding decides whether the interval of k has a lower bound at all; if it has one, then far below any k of such a curve.
    EXPECT_FALSE(has(fit.verdict(), "is determined")) << fit.verdict();
    EXPECT_LT(fit.permeability_interval_m2().low, 1e-8) << fit.verdict();
    EXPECT_TRUE(std::isinf(fit.permeability_interval_m2().high)) << fit.verdict();
    // A level that decreases only because of noise.
    LevelCurve constant{.name = "constant", .packing = {}, .time_s = {}, .level_m = {}};
    std::mt19937_64 random(3);
    std::normal_distribution<double> noise(0.0, 1e-3);
    for (int i = 0; i < 200; ++i) {
        constant.time_s.push_back(0.02 * i);
        constant.level_m.push_back(0.7 + noise(random));
    }
    constant.level_m.front() = 0.704;
    EXPECT_TRUE(has(test::message_of<UserError>([&] { (void)take_window(constant, FallingHeadConfig{}); }), "does not fall"));
    // Lengths in other units are marked as doubtful.
    FallingHeadConfig centimetres;
    centimetres.sample_length_m = 12.0;
    EXPECT_TRUE(take_window(curve, centimetres).doubtful);
    EXPECT_FALSE(take_window(curve, FallingHeadConfig{}).doubtful);
}

}  // namespace
}  // namespace porepack
