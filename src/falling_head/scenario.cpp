#include "falling_head/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/roots.hpp>

namespace porepack::falling_head {
namespace {

// The apparatus of Eq. 18: nothing but the sample.
FallingHeadConfig bare(FallingHeadConfig config) {
    config.column_inertia = false;
    config.screen_opening_m = config.screen_wire_m = config.loss_coefficient = config.level_offset_m = config.noise_m = 0.0;
    config.screen_free_fraction = 1.0;
    return config;
}

}  // namespace

ScenarioStudy::ScenarioStudy(const SampleTruth& truth, const FallingHeadConfig& config)
    : truth_(truth), full_(config), bare_(bare(config)) {
    if (full_.screen_opening_m > 0.0 && full_.screen_wire_m == 0.0) full_.screen_wire_m = 0.2 * full_.screen_opening_m;
}

Cause ScenarioStudy::evaluate(const ScenarioRow& row, const Scenario& from) const {
    Scenario scenario = from;
    row.change(scenario);
    if (row.noise_m > 0.0) return noise(row.name, row.what, scenario, row.noise_m);
    FallingHeadConfig assumed = bare_;
    if (!row.window_m.empty()) assumed.window_m = row.window_m;
    return factor(row.name, row.what, scenario, assumed);
}

PaperEvaluation ScenarioStudy::evaluation_of(const Scenario& scenario, const FallingHeadConfig& assumed) const {
    return evaluate_as_paper(take_window(simulate_curve(scenario.resistance, scenario.apparatus), assumed), assumed);
}

Cause ScenarioStudy::factor(const std::string& name, const std::string& what, const Scenario& scenario,
                            const FallingHeadConfig& assumed) const {
    Cause cause{.name = name, .what = what, .factor = {}};
    const PaperEvaluation paper = evaluation_of(scenario, assumed);
    if (paper.sound) cause.factor = truth_.permeability_m2 / paper.permeability_m2;
    cause.low = cause.high = cause.factor.value_or(0.0);
    cause.note = paper.fault;
    return cause;
}

Cause ScenarioStudy::noise(const std::string& name, const std::string& what, Scenario scenario, double noise_m) const {
    constexpr int trials = 400;
    scenario.apparatus.noise_m = noise_m;
    std::vector<double> factors;
    int failed = 0;
    for (int trial = 1; trial <= trials; ++trial) {
        scenario.apparatus.seed = trial;
        const PaperEvaluation paper = evaluation_of(scenario, bare_);
        if (paper.sound)
            factors.push_back(truth_.permeability_m2 / paper.permeability_m2);
        else
            ++failed;
    }
    Cause cause{.name = name, .what = what, .factor = {}};
    cause.note = fmt::format("{} of {} curves give no k", failed, trials);
    if (factors.size() < 20) return cause;
    std::sort(factors.begin(), factors.end());
    const auto at = [&](double share) { return factors[static_cast<std::size_t>(share * static_cast<double>(factors.size() - 1))]; };
    cause.factor = at(0.5);
    cause.low = at(0.16);
    cause.high = at(0.84);
    return cause;
}

std::optional<double> ScenarioStudy::explaining_offset(Scenario scenario, double factor_wanted) const {
    const auto excess = [&](double offset_m) -> std::optional<double> {
        scenario.apparatus.level_offset_m = offset_m;
        const Cause cause = factor("", "", scenario, bare_);
        return cause.factor ? std::optional(*cause.factor - factor_wanted) : std::nullopt;
    };
    double low = -0.03, high = 0.03;
    // With an increasing offset of the true level above the reading, k increases and finally does not exist.
    while (!excess(high) && low < high - 1e-4) high -= 1e-3;
    const auto at_low = excess(low), at_high = excess(high);
    if (!at_low || !at_high || *at_low * *at_high > 0.0) return std::nullopt;
    bool known = true;
    const auto sign = [&](double offset_m) {
        const auto here = excess(offset_m);
        known = known && here.has_value();
        return here.value_or(1.0) > 0.0 ? 1.0 : -1.0;
    };
    const double offset = boost::math::tools::bisect(sign, low, high, [](double a, double b) { return b - a <= 1e-6; }).first;
    return known ? std::optional(offset) : std::nullopt;
}

}  // namespace porepack::falling_head
