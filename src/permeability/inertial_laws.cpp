#include "permeability/inertial_laws.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace porepack::permeability {
namespace {

constexpr double deviations = 1.96, smallest_error = 1e-5;
constexpr double min_exponent = -0.9, max_exponent = 0.9;

// Each law says how the excess k/k_apparent - 1 grows with Re: Forchheimer's as c Re, the cubic law of weak inertia as c Re^2, a power as
// c Re^n. All are lines in Re^power, fitted by weighted least squares; the weights are the errors of the flows. Flows are divided
// where the excess exceeds strong_inertia: the weak law belongs to those below, the others to those above.
struct Excess {
    double reynolds, value, error;  ///< of k/k_apparent - 1
};

std::vector<Excess> excesses_of(const InertialCurve& curve) {
    std::vector<Excess> all;
    for (const ApparentPermeability& flow : curve.flows) {
        const double ratio = curve.permeability_m2 / flow.permeability_m2;
        all.push_back({flow.reynolds, ratio - 1.0, ratio * std::max(smallest_error, flow.relative_error)});
    }
    return all;
}

// value = intercept + coefficient Re^power; without an intercept, it is 0.
struct PowerLaw {
    double coefficient = 0.0, intercept = 0.0, coefficient_error = 0.0, intercept_error = 0.0, squares = 0.0;
};
PowerLaw fit_power_law(std::span<const Excess> flows, double power, bool with_intercept) {
    Eigen::Matrix2d sums = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    const double scale = std::pow(flows.back().reynolds, power);
    for (const Excess& flow : flows) {
        const Eigen::Vector2d row(std::pow(flow.reynolds, power) / scale, with_intercept ? 1.0 : 0.0);
        sums += row * row.transpose() / (flow.error * flow.error);
        right += row * flow.value / (flow.error * flow.error);
    }
    if (!with_intercept) sums(1, 1) = 1.0;
    const Eigen::Matrix2d inverse = sums.inverse();
    const Eigen::Vector2d found = inverse * right;
    PowerLaw law{.coefficient = found[0] / scale,
                 .intercept = found[1],
                 .coefficient_error = std::sqrt(inverse(0, 0)) / scale,
                 .intercept_error = std::sqrt(inverse(1, 1))};
    for (const Excess& flow : flows)
        law.squares += std::pow((law.coefficient * std::pow(flow.reynolds, power) + law.intercept - flow.value) / flow.error, 2.0);
    return law;
}

FittedLaw law_of(std::span<const Excess> flows, double power, bool with_intercept, std::size_t parameters) {
    const PowerLaw line = fit_power_law(flows, power, with_intercept);
    FittedLaw law{.flows = flows.size(), .reynolds_from = flows.front().reynolds, .reynolds_to = flows.back().reynolds};
    if (flows.size() > parameters) law.misfit = std::sqrt(line.squares / static_cast<double>(flows.size() - parameters));
    const double width = deviations * std::max(1.0, law.misfit);
    const auto around = [&](double value, double error) { return LawParameter{value, {value - width * error, value + width * error}}; };
    law.coefficient = around(line.coefficient, line.coefficient_error);
    if (with_intercept) law.intercept = around(line.intercept, line.intercept_error);
    return law;
}

// The power by which the squares are least, and the range in which they are less than `more` larger.
LawParameter best_power(std::span<const Excess> flows, double low, double high, bool with_intercept, std::size_t parameters) {
    const auto squares = [&](double power) { return fit_power_law(flows, power, with_intercept).squares; };
    constexpr int steps = 400;
    double best = low;
    for (int step = 1; step <= steps; ++step)
        if (const double power = low + (high - low) * step / steps; squares(power) < squares(best)) best = power;
    for (double step = (high - low) / steps; step > 1e-7; step *= 0.5)
        for (const double next : {best - step, best + step})
            if (next >= low && next <= high && squares(next) < squares(best)) best = next;
    const double minimum = squares(best), freedom = static_cast<double>(flows.size()) - static_cast<double>(parameters);
    const double more = deviations * deviations * std::max(1.0, freedom > 0.0 ? minimum / freedom : 1.0);
    const auto limit = [&](double end) {
        if (squares(end) <= minimum + more) return end;
        double inside = best, outside = end;
        while (std::abs(outside - inside) > 1e-6) {
            const double middle = 0.5 * (inside + outside);
            (squares(middle) <= minimum + more ? inside : outside) = middle;
        }
        return inside;
    };
    return {best, {limit(low), limit(high)}};
}

std::optional<FittedLaw> weak_law(std::span<const Excess> flows) {
    if (flows.size() < 2) return std::nullopt;
    FittedLaw law = law_of(flows, 2.0, false, 1);
    law.exponent = best_power(flows, 0.5, 4.0, false, 2);
    return law;
}

std::optional<FittedLaw> power_law(std::span<const Excess> flows) {
    if (flows.size() < 3) return std::nullopt;
    const LawParameter power = best_power(flows, 1.0 - max_exponent, 1.0 - min_exponent, true, 3);
    FittedLaw law = law_of(flows, power.value, true, 3);
    law.exponent = LawParameter{1.0 - power.value, {1.0 - power.interval.high, 1.0 - power.interval.low}};
    return law;
}

void widen(LawParameter& fine, const LawParameter& common, const LawParameter& coarse) {
    const double change = std::abs(common.value - coarse.value);
    fine.interval = {fine.interval.low - change, fine.interval.high + change};
}

void widen(std::optional<FittedLaw>& fine, const std::optional<FittedLaw>& common, const std::optional<FittedLaw>& coarse) {
    if (!fine || !common || !coarse) return;
    widen(fine->coefficient, common->coefficient, coarse->coefficient);
    if (fine->intercept) widen(*fine->intercept, *common->intercept, *coarse->intercept);
    if (fine->exponent) widen(*fine->exponent, *common->exponent, *coarse->exponent);
}

InertialLaws laws_of(std::span<const Excess> flows) {
    const auto strong = static_cast<std::size_t>(
        std::find_if(flows.begin(), flows.end(), [](const Excess& flow) { return flow.value > strong_inertia; }) - flows.begin());
    InertialLaws laws{.weak = weak_law(flows.first(strong)), .power = power_law(flows.subspan(strong))};
    if (flows.size() - strong >= 2) laws.forchheimer = law_of(flows.subspan(strong), 1.0, true, 2);
    return laws;
}

}  // namespace

InertialLaws fit_inertial_laws(const InertialCurve& curve, const std::optional<InertialCurve>& coarse) {
    const std::vector<Excess> flows = excesses_of(curve);
    InertialLaws laws = laws_of(flows);
    if (coarse) {
        const std::vector<Excess> other = excesses_of(*coarse);
        const std::size_t both = std::min(flows.size(), other.size());
        const InertialLaws common = laws_of(std::span(flows).first(both)), on_coarse = laws_of(std::span(other).first(both));
        widen(laws.weak, common.weak, on_coarse.weak);
        widen(laws.forchheimer, common.forchheimer, on_coarse.forchheimer);
        widen(laws.power, common.power, on_coarse.power);
    }
    const bool falls = laws.power && (laws.power->exponent->interval.low > 0.0 || laws.power->exponent->interval.high < 0.0);
    if (laws.forchheimer) laws.strong_law = falls ? "power law" : "Forchheimer";
    return laws;
}

}  // namespace porepack::permeability
