#include "design/answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "design/design_page.hpp"
#include "design/uses.hpp"
#include "report/page.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::design {
namespace {

// What stops the search: at the wanted permeability, the porosity; or the range of k among the allowed porosities.
std::string obstacle(const DesignGoal& goal, const std::vector<SizedCandidate>& all) {
    Interval k = {std::numeric_limits<double>::infinity(), 0.0}, eps = {1.0, 0.0};
    for (const SizedCandidate& one : all) {
        const double porosity = one.prediction.porosity.value;
        const double value = expected_permeability_m2(one);
        if (!goal.porosity || (porosity >= goal.porosity->low - 0.005 && porosity <= goal.porosity->high + 0.005))
            k = {std::min(k.low, value), std::max(k.high, value)};
        if (value >= 0.9 * goal.permeability_m2.low && value <= 1.1 * goal.permeability_m2.high)
            eps = {std::min(eps.low, porosity), std::max(eps.high, porosity)};
    }
    const auto range = [](const Interval& x, const char* format) {
        return fmt::format(fmt::runtime(fmt::format("{} to {}", format, format)), x.low, x.high);
    };
    std::string text;
    if (k.high > 0.0)
        text += fmt::format("{}allowed grains are expected to have k from {} m²",
                            goal.porosity ? "With a porosity as wanted, the " : "The ", range(k, "{:.2g}"));
    else
        text += "No allowed grain is expected to have such a porosity";
    if (goal.porosity && eps.high > 0.0) text += fmt::format("; with k as wanted, porosities from {}", range(eps, "{:.2f}"));
    return text;
}

}  // namespace

std::string answer_of(const DesignGoal& goal, const DesignBed& bed, const std::vector<KnownBed>& known, const DesignResult& result,
                      bool out_of_time) {
    std::vector<const Proposal*> computed;
    for (const Proposal& p : result.proposals)
        if (p.error.empty()) computed.push_back(&p);
    if (computed.empty()) return "No proposal could be computed: see proposals.csv.";
    const double k_scatter = permeability_scatter(known).typical().value_or(scatter_without_data);
    const double eps_scatter = porosity_scatter(known).typical().value_or(porosity_scatter_without_data);
    const auto far = [&](const Proposal* p) {
        const double k = std::log(std::clamp(p->permeability_m2, goal.permeability_m2.low, goal.permeability_m2.high) / p->permeability_m2);
        const double eps = goal.porosity ? std::clamp(p->bed.porosity, goal.porosity->low, goal.porosity->high) - p->bed.porosity : 0.0;
        return std::hypot(k / k_scatter, eps / eps_scatter);
    };
    const Proposal& nearest = **std::min_element(computed.begin(), computed.end(), [&](auto* a, auto* b) { return far(a) < far(b); });
    const std::string grain =
        fmt::format("{}: k = {:.3g} m² {} and porosity {:.3f} ({:.3f} to {:.3f}) (mean of {} packings, 95 %)", description(nearest.grain),
                    nearest.permeability_m2, percent_text(nearest.permeability_m2, nearest.permeability_interval_m2), nearest.bed.porosity,
                    nearest.porosity_interval.low, nearest.porosity_interval.high, nearest.bed.packings);
    std::string text = result.verdict == Verdict::hit ? "Found. " + grain
                       : result.verdict == Verdict::out_of_reach
                           ? "Out of reach. Nearest: " + grain + ". " + obstacle(goal, result.reachable)
                           : fmt::format("Not hit in {} proposals. Nearest: ", result.proposals.size()) + grain;
    text += ".";
    if (nearest.permeability_half_width() > goal.within)
        text += fmt::format(" Its interval is wider than {:g} %: it takes more packings per proposal (--packings).", 100.0 * goal.within);
    if (goal.volume_m3 == 0.0)
        text +=
            " The volume was free: k grows as volume^(2/3) as long as the container is wide, so other shapes of other volumes have "
            "this k, too; the porosity chooses among them.";
    if (nearest.magnified_from != 0)
        text += fmt::format(" Its bed is that of proposal {}, magnified: k grows as the square of lengths. It was not poured again.",
                            nearest.magnified_from);
    if (result.verdict == Verdict::not_hit && out_of_time)
        text += fmt::format(" The search ended after {} (--max-time); the same command resumes it.", human_time(goal.max_time_s));
    if (bed.shrink(nearest.grain.size_m) < 1.0)
        text += fmt::format(" The bed was poured in a container {:g} grains wide; the wall of the wider one changes k less.", widest_bed);
    if (nearest.grain.prediction.extrapolated)
        text += " The grain or its container lies outside the beds that the search began with; the computed values do not depend on them.";
    return text;
}

Json plan_of(const DesignGoal& goal, const DesignBed& bed, const Forecaster& forecaster) {
    const std::vector<KnownBed>& known = forecaster.known();
    const std::vector<SizedCandidate> all = forecaster.forecasts({});
    const SizedCandidate first = *best(all, {});
    const Prediction& expected = first.prediction;
    const Expectation cost = expected_of(case_pipeline(bed.planned(first, goal.packings)), last_stage);
    Json json = {{"first_proposal", description(first)},
                 {"chance", first.chance},
                 {"expected_of_first_proposal",
                  {{"permeability_m2", expected_permeability_m2(first)},
                   {"permeability_relative_deviation", expected.log_permeability.standard_deviation},
                   {"porosity", expected.porosity.value},
                   {"porosity_deviation", expected.porosity.standard_deviation},
                   {"extrapolated", expected.extrapolated},
                   {"cost", core::text_of(cost, slowness())}}},
                 {"beds_known", known.size()},
                 {"expected_half_width", forecaster.expected_half_widths().permeability}};
    // How well the beds predict each other.
    const Surrogate surrogate(known);
    double k_squares = 0.0, eps_squares = 0.0;
    for (std::size_t i = 0; i < known.size(); ++i) {
        const Prediction p = surrogate.leave_one_out(i);
        k_squares += std::pow(p.log_permeability.value - std::log(known[i].permeability), 2) / static_cast<double>(known.size());
        eps_squares += std::pow(p.porosity.value - known[i].porosity, 2) / static_cast<double>(known.size());
    }
    json["leave_one_out_error"] = {{"log_permeability", std::sqrt(k_squares)}, {"porosity", std::sqrt(eps_squares)}};
    Interval k = {std::numeric_limits<double>::infinity(), 0.0}, eps = {1.0, 0.0};
    for (const SizedCandidate& one : all) {
        const double value = expected_permeability_m2(one);
        k = {std::min(k.low, value), std::max(k.high, value)};
        eps = {std::min(eps.low, one.prediction.porosity.value), std::max(eps.high, one.prediction.porosity.value)};
    }
    const auto rounded = [](double value) { return std::stod(fmt::format("{:.4g}", value)); };
    json["reachable_permeability_m2"] = {rounded(k.low), rounded(k.high)};
    json["reachable_porosity"] = {rounded(eps.low), rounded(eps.high)};
    return json;
}

}  // namespace porepack::design
