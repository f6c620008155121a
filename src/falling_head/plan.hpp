// Which falling-head test tells k? Tests are simulated in several fluids, with several sample lengths and windows, and analysed.
#pragma once

#include <optional>
#include <vector>

#include "falling_head/column.hpp"

namespace porepack::falling_head {

/// Viscosity and density of glycerol in water (Cheng 2008; 0 to 100 C), `fraction` by mass.
struct GlycerolSolution {
    double kinematic_viscosity_m2_per_s, density_kg_per_m3;
};
[[nodiscard]] GlycerolSolution glycerol_solution(double fraction, double temperature_celsius);

struct TestPlanConfig {
    std::vector<double> glycerol_fractions = {0.0, 0.4, 0.6, 0.75, 0.85};
    std::vector<double> sample_lengths_m = {};
    std::vector<double> window_tops_m = {};
    long runs = 3;
    double temperature_celsius = 20.0;
    double half_width = 0.05;
};
inline void describe(record::ConfigVisitor& v, TestPlanConfig& c) {
    v.numbers("glycerol_fractions", c.glycerol_fractions, {1, 20}, record::between(0.0, 1.0), "fluids to try: mass of glycerol in water");
    v.numbers("sample_lengths_m", c.sample_lengths_m, {0, 20}, record::length_range(),
              "lengths to try; auto: sample_length_m, and 2 and 4 times");
    v.numbers("window_tops_m", c.window_tops_m, {0, 20}, record::length_range(),
              "upper ends of the window to try, with the given lower end; auto: that of window_m, and a third of it");
    v.integer("runs", c.runs, record::between(1, 100), "curves that are recorded and analysed together");
    v.number("celsius", c.temperature_celsius, record::between(0.0, 60.0), "temperature");
    v.number("within", c.half_width, record::between(1e-3, 1.0), "wanted half width of the interval of k, relative");
}

struct PlannedTest {
    double glycerol_fraction, kinematic_viscosity_m2_per_s, sample_length_m;
    std::vector<double> window_m;
    double duration_s = 0.0;           ///< from the opening of the outlet to the end of the window
    double fastest_m_per_s = 0.0;      ///< at the top of the window
    double viscous_share = 0.0;        ///< of the head, over the window
    std::optional<double> half_width;  ///< wider side of the 95 % interval of 1/k, relative; none: it has an open end or no fit was found
    std::optional<double> half_width_inertial;
};

/// All combinations, from the cheapest on: less glycerol, then shorter samples, then lower windows. `apparatus` has the noise, the frames
/// per second and the uncertainties. A reference speed of the inertial exponent is taken at the same Reynolds number in all fluids.
[[nodiscard]] std::vector<PlannedTest> plan_tests(const Resistance& sample, const FallingHeadConfig& apparatus,
                                                  const TestPlanConfig& config);

/// The apparatus of one of them.
[[nodiscard]] FallingHeadConfig apparatus_of(const PlannedTest& test, const Resistance& sample, FallingHeadConfig apparatus);

}  // namespace porepack::falling_head
