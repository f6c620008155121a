// Laws of inertia, fitted to k/k_apparent - 1 at rising Reynolds numbers: which of them the flows show, and in which range.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/interval.hpp"
#include "core/members.hpp"
#include "permeability/forchheimer.hpp"

namespace porepack::permeability {

/// A parameter with its 95 % interval.
struct LawParameter {
    double value = 0.0;
    core::Interval interval = {};
};
template <core::MembersOf<LawParameter> Self, typename Visit>
void visit_members(Self& parameter, const Visit& visit) {
    visit("value", parameter.value);
    visit("interval", parameter.interval);
}

struct FittedLaw {
    std::size_t flows = 0;  ///< that it was fitted to
    double reynolds_from = 0.0, reynolds_to = 0.0;
    double misfit = 0.0;            ///< root mean square of the residuals over their errors: 1 or less is as good as the flows are known
    LawParameter coefficient = {};  ///< of Re^2, Re or Re^(1-n), at the exponent that was found
    std::optional<LawParameter> intercept = {};
    std::optional<LawParameter> exponent = {};  ///< weak inertia: fitted instead of 2, as a check; power law: n
};
template <core::MembersOf<FittedLaw> Self, typename Visit>
void visit_members(Self& law, const Visit& visit) {
    visit("flows", law.flows);
    visit("reynolds_from", law.reynolds_from);
    visit("reynolds_to", law.reynolds_to);
    visit("misfit", law.misfit);
    visit("coefficient", law.coefficient);
    visit("intercept", law.intercept);
    visit("exponent", law.exponent);
}

/// Weak inertia: a Re^2 (Mei & Auriault 1991), for the flows below `strong`. Forchheimer: c + b Re, and a power law c + b Re^(1-n), by
/// which 1/k_in falls like Re^-n, for the others. None where the flows are too few: two, two and three.
struct InertialLaws {
    std::optional<FittedLaw> weak = {}, forchheimer = {}, power = {};
    std::string strong_law = "none";  ///< of the flows with strong inertia: "power law" where n differs from 0 by more than its interval
};
template <core::MembersOf<InertialLaws> Self, typename Visit>
void visit_members(Self& laws, const Visit& visit) {
    visit("weak_inertia", laws.weak);
    visit("forchheimer", laws.forchheimer);
    visit("power_law", laws.power);
    visit("strong_inertia_follows", laws.strong_law);
}

/// k/k_apparent - 1 from which inertia is strong: the onset.
inline constexpr double strong_inertia = 1.0 / 0.95 - 1.0;

/// Least squares, weighted by the flows' errors. Intervals: where the sum of squares rises by 1.96^2 times the larger of 1 and the misfit
/// squared, so they hold iteration and misfit, and with `coarse`, the same on the next coarser grid, its change to this one too.
[[nodiscard]] InertialLaws fit_inertial_laws(const InertialCurve& curve, const std::optional<InertialCurve>& coarse = {});

}  // namespace porepack::permeability
