#include "falling_head/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/sides.hpp"
#include "falling_head/causes.hpp"
#include "falling_head/falling_head.hpp"
#include "falling_head/least_squares.hpp"

namespace porepack::falling_head {
namespace {

constexpr double max_frames = 400.0;  // of a curve: a slow test needs fewer frames per second

void measure(PlannedTest& test, const Resistance& sample, const FallingHeadConfig& apparatus, long runs) {
    std::vector<LevelCurve> curves;
    for (long run = 1; run <= runs; ++run) {
        FallingHeadConfig one = apparatus;
        one.seed = run;
        curves.push_back(take_window(simulate_curve(sample, one), one));
    }
    test.duration_s = curves.front().time_s.back();
    const FallingHeadFit fit = fit_falling_head(curves, apparatus);
    test.viscous_share = fit.viscous_share;
    const auto half_width = [](const FittedValue& fitted) {
        const double half = half_widths(fitted.value, fitted.interval).wider() / fitted.value;
        return std::isfinite(half) && fitted.interval.low > 0.0 ? std::optional(half) : std::nullopt;
    };
    test.half_width = half_width(fit.inverse_permeability_per_m2);
    test.half_width_inertial = half_width(fit.inverse_inertial_permeability_per_m);
}

}  // namespace

GlycerolSolution glycerol_solution(double fraction, double temperature_celsius) {
    const double T = temperature_celsius, C = fraction;
    const double water = 1.790e-3 * std::exp((-1230.0 - T) * T / (36100.0 + 360.0 * T));
    const double glycerol = 12.1 * std::exp((-1233.0 + T) * T / (9900.0 + 70.0 * T));
    const double a = 0.705 - 0.0017 * T, b = (4.9 + 0.036 * T) * std::pow(a, 2.5);
    const double alpha = 1.0 - C + a * b * C * (1.0 - C) / (a * C + b * (1.0 - C));
    const double density = (1277.0 - 0.654 * T) * C + 1000.0 * (1.0 - std::pow(std::abs(T - 4.0) / 622.0, 1.7)) * (1.0 - C);
    return {std::pow(water, alpha) * std::pow(glycerol, 1.0 - alpha) / density, density};
}

FallingHeadConfig apparatus_of(const PlannedTest& test, const Resistance& sample, FallingHeadConfig apparatus) {
    apparatus.inertial_reference_speed_m_per_s *= test.kinematic_viscosity_m2_per_s / apparatus.kinematic_viscosity_m2_per_s;
    apparatus.kinematic_viscosity_m2_per_s = test.kinematic_viscosity_m2_per_s;
    apparatus.sample_length_m = test.sample_length_m;
    apparatus.window_m = test.window_m;
    apparatus.start_level_m = std::min(apparatus.start_level_m, 1.25 * test.window_m[1]);
    const FallingHead ideal(1.0 / sample.inverse_permeability_per_m2, 1.0 / sample.inverse_inertial_permeability_per_m, apparatus);
    apparatus.frames_per_s = std::min(apparatus.frames_per_s, max_frames / ideal.time_at(test.window_m[0]));
    return apparatus;
}

std::vector<PlannedTest> plan_tests(const Resistance& sample, const FallingHeadConfig& apparatus, const TestPlanConfig& config) {
    std::vector<double> fluids = config.glycerol_fractions, lengths = config.sample_lengths_m, tops = config.window_tops_m;
    const double bottom = std::min(apparatus.window_m[0], apparatus.window_m[1]),
                 top = std::max(apparatus.window_m[0], apparatus.window_m[1]);
    if (lengths.empty()) lengths = {apparatus.sample_length_m, 2.0 * apparatus.sample_length_m, 4.0 * apparatus.sample_length_m};
    if (tops.empty()) tops = {std::max(2.0 * bottom, top / 3.0), top};
    std::sort(fluids.begin(), fluids.end());
    std::sort(lengths.begin(), lengths.end());
    std::sort(tops.begin(), tops.end());
    if (tops.front() <= bottom)
        throw UserError("the window has no height", {.where = "window_tops_m", .allowed = "above the lower end of window_m"});
    if (tops.back() > apparatus.start_level_m)
        throw UserError(fmt::format("a window that begins at {:g} m lies above the start of the test", tops.back()),
                        {.where = "window_tops_m", .allowed = fmt::format("at most start_level_m, {:g} m", apparatus.start_level_m)});
    const double water = glycerol_solution(0.0, config.temperature_celsius).kinematic_viscosity_m2_per_s;
    std::vector<PlannedTest> tests;
    for (const double fluid : fluids)
        for (const double length : lengths)
            for (const double high : tops) {
                PlannedTest test{.glycerol_fraction = fluid,
                                 .kinematic_viscosity_m2_per_s =
                                     apparatus.kinematic_viscosity_m2_per_s *
                                     glycerol_solution(fluid, config.temperature_celsius).kinematic_viscosity_m2_per_s / water,
                                 .sample_length_m = length,
                                 .window_m = {bottom, high},
                                 .half_width = {},
                                 .half_width_inertial = {}};
                tests.push_back(test);
            }
    parallel_for(tests.size(), [&](std::size_t i) {
        const FallingHeadConfig one = apparatus_of(tests[i], sample, apparatus);
        tests[i].fastest_m_per_s = Column(one).steady_speed(sample, one.window_m[1]);
        try {
            measure(tests[i], sample, one, config.runs);
        } catch (const NumericalError&) {  // no fit: a row without half widths
        }
    });
    return tests;
}

}  // namespace porepack::falling_head
