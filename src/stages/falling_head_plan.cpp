#include "stages/falling_head_plan.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/table.hpp"
#include "stages/results.hpp"

namespace porepack::stages {
using namespace core;
using namespace falling_head;

Json plan_falling_head(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& apparatus,
                       const TestPlanConfig& config, const Path& folder) {
    if (!(apparatus.noise_m > 0.0))
        throw UserError("a plan needs the noise of the levels", {.where = "noise_m", .fix = "--noise 1e-3 (metres, standard deviation)"});
    if (!(permeability_m2 > 0.0) || !(inertial_permeability_m > 0.0) || !std::isfinite(inertial_permeability_m))
        throw UserError("a plan needs about the k and k_in of the sample", {.allowed = "positive numbers, as of `porepack forchheimer`"});
    const std::vector<PlannedTest> tests = plan_tests({1.0 / permeability_m2, 1.0 / inertial_permeability_m}, apparatus, config);
    Table table({"glycerol_fraction", "kinematic_viscosity_m2_per_s", "sample_length_m", "window_low_m", "window_high_m", "duration_s",
                 "fastest_m_per_s", "viscous_share_of_head", "half_width_k", "half_width_k_in"});
    table.digits = 4;
    Json rows = Json::array(), cheapest = nullptr, best = nullptr;
    for (const PlannedTest& test : tests) {
        table.add(test.glycerol_fraction, test.kinematic_viscosity_m2_per_s, test.sample_length_m, test.window_m[0], test.window_m[1],
                  test.duration_s, test.fastest_m_per_s, test.viscous_share, test.half_width, test.half_width_inertial);
        rows.push_back({{"glycerol_fraction", test.glycerol_fraction},
                        {"kinematic_viscosity_m2_per_s", test.kinematic_viscosity_m2_per_s},
                        {"sample_length_m", test.sample_length_m},
                        {"window_m", test.window_m},
                        {"duration_s", test.duration_s},
                        {"fastest_m_per_s", test.fastest_m_per_s},
                        {"viscous_share_of_head", test.viscous_share},
                        {"half_width_k", json_of(test.half_width)},
                        {"half_width_k_in", json_of(test.half_width_inertial)}});
        if (!test.half_width) continue;
        if (cheapest.is_null() && *test.half_width <= config.within) cheapest = rows.back();
        if (best.is_null() || *test.half_width < best["half_width_k"].get<double>()) best = rows.back();
    }
    table.write(folder / "plan.csv");
    return {{"within", config.within},
            {"cheapest", cheapest},
            {"most_certain", best},
            {"verdict", cheapest.is_null()
                            ? std::string("none of these tests tells k so well")
                            : fmt::format("cheapest: {:.0f} % of glycerol, a sample of {:g} m, levels from {:g} to {:g} m: k to {:.2g} %",
                                          100.0 * cheapest["glycerol_fraction"].get<double>(), cheapest["sample_length_m"].get<double>(),
                                          cheapest["window_m"][1].get<double>(), cheapest["window_m"][0].get<double>(),
                                          100.0 * cheapest["half_width_k"].get<double>())},
            {"tests", rows},
            {"meaning",
             "half_width: the wider side of the 95 % interval of 1/k and 1/k_in, relative, of simulated tests with this noise and these "
             "uncertainties; null: "
             "the interval has an open end. Cheaper is: less glycerol, then a shorter sample, then a lower column"}};
}

}  // namespace porepack::stages
