#include "analysis/falling_head/plan_of_test.hpp"

#include <fmt/format.h>

#include <cmath>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/table.hpp"

namespace porepack::analysis {

Outcome<results::FallingHeadPlan> plan_falling_head(double permeability_m2, double inertial_permeability_m,
                                                    const FallingHeadConfig& apparatus, const TestPlanConfig& config) {
    if (!(apparatus.noise_m > 0.0))
        throw UserError("a plan needs the noise of the levels", {.where = "noise_m", .fix = "--noise 1e-3 (metres, standard deviation)"});
    if (!(permeability_m2 > 0.0) || !(inertial_permeability_m > 0.0) || !std::isfinite(inertial_permeability_m))
        throw UserError("a plan needs about the k and k_in of the sample", {.allowed = "positive numbers, as of `porepack forchheimer`"});
    Table table({"glycerol_fraction", "kinematic_viscosity_m2_per_s", "sample_length_m", "window_low_m", "window_high_m", "duration_s",
                 "fastest_m_per_s", "viscous_share_of_head", "half_width_k", "half_width_k_in"});
    table.digits = 4;
    results::FallingHeadPlan plan{.within = config.half_width, .verdict = "none of these tests tells k so well"};
    for (const PlannedTest& test : plan_tests({1.0 / permeability_m2, 1.0 / inertial_permeability_m}, apparatus, config)) {
        table.add(test.glycerol_fraction, test.kinematic_viscosity_m2_per_s, test.sample_length_m, test.window_m[0], test.window_m[1],
                  test.duration_s, test.fastest_m_per_s, test.viscous_share, test.half_width, test.half_width_inertial);
        const results::PlannedTest& row = plan.tests.emplace_back(
            results::PlannedTest{test.glycerol_fraction, test.kinematic_viscosity_m2_per_s, test.sample_length_m, test.window_m,
                                 test.duration_s, test.fastest_m_per_s, test.viscous_share, test.half_width, test.half_width_inertial});
        if (!row.half_width_k) continue;
        if (!plan.cheapest && *row.half_width_k <= config.half_width) plan.cheapest = row;
        if (!plan.narrowest || *row.half_width_k < *plan.narrowest->half_width_k) plan.narrowest = row;
    }
    if (const auto& best = plan.cheapest)
        plan.verdict = fmt::format("cheapest: {:.0f} % of glycerol, a sample of {:g} m, levels from {:g} to {:g} m: k to {:.2g} %",
                                   100.0 * best->glycerol_fraction, best->sample_length_m, best->window_m[1], best->window_m[0],
                                   100.0 * *best->half_width_k);
    return {plan, {.tables = {{"plan.csv", table}}}};
}

}  // namespace porepack::analysis
