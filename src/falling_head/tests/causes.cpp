// What the causes of a wrong k are made of, against exact solutions and published figures.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/sides.hpp"
#include "falling_head/causes.hpp"
#include "falling_head/column.hpp"
#include "falling_head/falling_head.hpp"
#include "falling_head/least_squares.hpp"
#include "falling_head/plan.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

constexpr double k_in = 4.4e-3;

FallingHeadConfig without_inertia() {
    FallingHeadConfig config;
    config.column_inertia = false;
    return config;
}

SampleTruth tetrapods() {
    return {.permeability_m2 = 6.26e-7, .inertial_permeability_m = k_in, .porosity = 0.68, .grain_diameter_m = 0.0112};
}

// Without viscous loss v = C (h + L)^p with p = 1/(2 - n): an exact power law in time.
TEST(Column, AFallingInertialCoefficientIsAPowerLaw) {
    FallingHeadConfig config = without_inertia();
    const double L = config.sample_length_m, g = config.gravity_m_per_s2, reference = 0.003;
    for (const double n : {0.02, 0.1, 0.2}) {
        config.inertial_exponent = n;
        config.inertial_reference_speed_m_per_s = reference;
        const double p = 1.0 / (2.0 - n), C = std::pow(g * k_in / L * std::pow(reference, -n), p);
        const std::vector<double> times = {0.2, 0.5, 1.0};
        const auto levels = Column(config).levels({0.0, 1.0 / k_in}, 0.0, 1.6, 0.0, times);
        for (std::size_t i = 0; i < times.size(); ++i)
            EXPECT_NEAR(levels[i], std::pow(std::pow(1.6 + L, 1.0 - p) - (1.0 - p) * C * times[i], 1.0 / (1.0 - p)) - L, 1e-8) << n;
    }
    config.inertial_reference_speed_m_per_s = 0.0;
    EXPECT_THROW(Column{config}, core::UserError);
}

// The same water, read on a scale that is wrong about the middle of the window.
TEST(Column, AWrongScaleChangesTheReadingAlone) {
    FallingHeadConfig right, wrong;
    wrong.scale_error = 0.01;
    const Resistance sample{1.0 / 6.26e-7, 1.0 / k_in};
    const std::vector<double> times = {0.5, 1.0, 2.0};
    const double start = 0.7 + (1.6 - 0.7) / 1.01;  // what the wrong scale shows for 1.6 m
    const auto truth = Column(right).levels(sample, 0.0, 1.6, 0.0, times), read = Column(wrong).levels(sample, 0.0, start, 0.0, times);
    for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(0.7 + 1.01 * (read[i] - 0.7), truth[i], 1e-9);
}

// Friction K' h v^2/2 beside the sample's v^2 L/k_in.
TEST(Column, FrictionOnTheTubeGrowsWithTheLevel) {
    FallingHeadConfig config = without_inertia();
    config.column_friction_per_m = 0.3;
    const double L = config.sample_length_m, g = config.gravity_m_per_s2;
    for (const double level : {0.1, 0.7, 1.3})
        EXPECT_NEAR(Column(config).steady_speed({0.0, 1.0 / k_in}, level), std::sqrt(g * (level + L) / (L / k_in + 0.15 * level)), 1e-12);
}

// IAPWS R12-08, Table: 1.5182, 1.0016, 0.8900, 0.6527 mPa s.
TEST(Causes, ViscosityOfWater) {
    for (const auto& [celsius, viscosity] :
         {std::pair(5.0, 1.5182), std::pair(20.0, 1.0016), std::pair(25.0, 0.8900), std::pair(40.0, 0.6527)})
        EXPECT_NEAR(water_viscosity_ratio(celsius) * 1.0016 / viscosity, 1.0, 2e-3) << celsius;
}

TEST(Causes, EachIsNothingAtItsAbsentValue) {
    const FallingHeadConfig config{.screen_opening_m = 8e-3};
    const SampleTruth truth = tetrapods();
    for (const UncertainCause& cause : uncertain_causes(truth, config)) {
        EXPECT_LE(cause.low, cause.high) << cause.name;
        EXPECT_FALSE(cause.source.empty()) << cause.name;
        // The screen is there, even if nothing covers it; the outlet and the inertia of the water belong together.
        if (!cause.absent || cause.name == "screen below partly covered" || cause.name == "opening of the outlet") continue;
        Scenario scenario{without_inertia(), {1.0 / truth.permeability_m2, 1.0 / truth.inertial_permeability_m}};
        const Resistance before = scenario.resistance;
        const double speed = Column(scenario.apparatus).steady_speed(before, 0.7);
        cause.apply(scenario, *cause.absent);
        EXPECT_NEAR(Column(scenario.apparatus).steady_speed(scenario.resistance, 0.7), speed, 1e-12) << cause.name;
    }
}

TEST(Causes, FactorsAreThoseOfTheEquation) {
    SampleTruth truth = tetrapods();
    truth.ends_viscous = 1.02;
    const CauseStudy study = study_causes(truth, {.screen_opening_m = 8e-3}, 2.8, 60);
    std::map<std::string, CauseFactors> by_name;
    for (const CauseFactors& found : study.causes) by_name.emplace(found.cause.name, found);
    EXPECT_NEAR(study.evaluation_alone, 1.0, 0.03) << "the polynomial's own error";
    // k by Eq. 18 is proportional to the viscosity that is assumed.
    const CauseFactors& warm = by_name.at("temperature");
    EXPECT_NEAR(warm.at_low.value() / warm.at_high.value(), water_viscosity_ratio(15.0) / water_viscosity_ratio(25.0), 0.03);
    const CauseFactors& zero = by_name.at("zero of the level");
    EXPECT_GT(zero.at_low.value(), 1.2);
    EXPECT_LT(zero.at_high.value(), 0.8);
    EXPECT_GT(by_name.at("falling inertial coefficient").at_high.value_or(0.0), 3.0);
    ASSERT_EQ(study.joint.size(), 4U);
    for (const JointFactors& joint : study.joint) {
        EXPECT_EQ(joint.draws, 60);
        EXPECT_NEAR(static_cast<double>(joint.factors.size()) / 60.0 + joint.without_k, 1.0, 1e-12);
    }
    const CauseStudy again = study_causes(truth, {.screen_opening_m = 8e-3}, 2.8, 60);
    EXPECT_EQ(study.joint[0].factors, again.joint[0].factors) << "on any number of threads";
}

// The same sample twice: what both tests have in common makes their factors go together; what each has for itself keeps them apart.
TEST(Causes, CommonOnesActOnBothTests) {
    const TestedSample sample{.truth = tetrapods(), .apparatus = {.screen_opening_m = 8e-3}, .factor = 2.8};
    const std::vector<PairedFactors> found = study_common_causes({sample, sample}, 300);
    ASSERT_EQ(found.size(), 3U);
    const auto mean_log_ratio = [](const PairedFactors& paired, std::size_t shift) {
        double sum = 0.0, count = 0.0;
        for (std::size_t i = 0; i < paired.draws.size(); ++i) {
            const auto &one = paired.draws[i].factors[0], &two = paired.draws[(i + shift) % paired.draws.size()].factors[1];
            if (!one || !two) continue;
            sum += std::abs(std::log(*one / *two));
            count += 1.0;
        }
        EXPECT_GT(count, 200.0);
        return sum / count;
    };
    // Fewer than all causes are common, so the ratio is neither 0 nor that of independent draws; 300 draws know it to some 5 %.
    // Narrow ranges, where nearly all draws have a k: in the same draw the factors are nearer to each other than in different ones.
    EXPECT_LT(mean_log_ratio(found[1], 0), 0.8 * mean_log_ratio(found[1], 1));
    EXPECT_GT(mean_log_ratio(found[1], 0), 0.0);
    const CauseStudy alone = study_causes(sample.truth, sample.apparatus, 2.8, 300);
    std::vector<double> factors;
    for (const PairedDraw& draw : found[0].draws)
        if (draw.factors[1]) factors.push_back(*draw.factors[1]);
    std::sort(factors.begin(), factors.end());
    EXPECT_NEAR(factors[factors.size() / 2] / alone.joint[0].median.value(), 1.0, 0.15)
        << "each sample's factors are those of it alone; two medians of 300 draws differ by 5 %";
}

// Segur & Oberstar 1951, at 20 C: 1.005, 3.72, 10.8, 60.1 mPa s at 0, 40, 60, 80 % of glycerol.
TEST(TestPlan, ViscosityOfGlycerol) {
    for (const auto& [fraction, viscosity] :
         {std::pair(0.0, 1.005e-3), std::pair(0.4, 3.72e-3), std::pair(0.6, 10.8e-3), std::pair(0.8, 60.1e-3)}) {
        const GlycerolSolution found = glycerol_solution(fraction, 20.0);
        EXPECT_NEAR(found.kinematic_viscosity_m2_per_s * found.density_kg_per_m3 / viscosity, 1.0, 0.05) << fraction;
    }
    EXPECT_NEAR(glycerol_solution(0.5, 20.0).density_kg_per_m3, 1126.0, 10.0);
}

// In water a falling head cannot tell k; in glycerol it can, and tests that follow the plan are as sure as it says.
TEST(TestPlan, ItsTestsTellWhatItPromises) {
    FallingHeadConfig apparatus{.level_offset_uncertainty_m = 1e-3, .scale_uncertainty = 0.002, .noise_m = 1e-3};
    const Resistance sample{1.0 / 6.26e-7, 1.0 / k_in};
    const std::vector<PlannedTest> tests =
        plan_tests(sample, apparatus, {.glycerol_fractions = {0.0, 0.75}, .sample_lengths_m = {0.12, 0.24}, .window_tops_m = {1.3}});
    ASSERT_EQ(tests.size(), 4U);
    EXPECT_GT(tests[0].half_width.value_or(10.0), 0.3);
    const PlannedTest& planned = tests[2];
    ASSERT_TRUE(planned.half_width.has_value());
    EXPECT_LT(*planned.half_width, 0.1);
    EXPECT_GT(planned.viscous_share, 0.2);

    const FallingHeadConfig assumed = apparatus_of(planned, sample, apparatus);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<double> widths;
    int held = 0;
    for (long trial = 0; trial < 20; ++trial) {
        FallingHeadConfig truth = assumed;
        truth.level_offset_m += 1e-3 * normal(random);
        truth.scale_error += 0.002 * normal(random);
        std::vector<LevelCurve> curves;
        for (long run = 0; run < 3; ++run) {
            truth.seed = 100 + 3 * trial + run;
            curves.push_back(take_window(simulate_curve(sample, truth), assumed));
        }
        const FittedValue found = fit_falling_head(curves, assumed).inverse_permeability_per_m2;
        widths.push_back(half_widths(found.value, found.interval).wider() / found.value);
        held += found.interval.low <= sample.inverse_permeability_per_m2 && sample.inverse_permeability_per_m2 <= found.interval.high;
    }
    std::sort(widths.begin(), widths.end());
    EXPECT_NEAR(widths[10] / *planned.half_width, 1.0, 0.3);
    EXPECT_GE(held, 17);
}

}  // namespace
}  // namespace porepack
