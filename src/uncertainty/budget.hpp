// Uncertainty budget: the contributions to the uncertainty of a quantity, and the three statements that follow from them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/interval.hpp"
#include "core/members.hpp"
#include "core/sides.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::uncertainty {

/// How the size of a contribution is known: from data of this case, as an upper bound, or by judgement from other cases.
enum class Evidence { measured, bounded, judged };
constexpr std::array<core::Choice<Evidence>, 3> choices_of(Evidence) {
    return {{{Evidence::measured, "measured"}, {Evidence::bounded, "bounded"}, {Evidence::judged, "judged"}}};
}

/// How a contribution enters the statements:
///   - numerical: the error of the computation in one packing. It is in all three statements and does not shrink with the number of
///     packings, because the same method makes it in each;
///   - input: an uncertain input of the case, as friction. It is in the statements about the mean and the next packing, and does not
///   shrink;
///   - scatter: between packings. It is not in the statement about this packing; in that about the mean it shrinks as 1/sqrt(n);
///   - hint: not in any statement. What the layers tell of the scatter where it is not known; what half the resolution of an image does;
///     the usual effect of friction.
enum class Part { numerical, input, scatter, hint };
constexpr std::array<core::Choice<Part>, 4> choices_of(Part) {
    return {{{Part::numerical, "numerical"}, {Part::input, "input"}, {Part::scatter, "scatter"}, {Part::hint, "hint"}}};
}

struct BudgetRow {
    std::string source;                         ///< "grid", "packing to packing", ...
    core::Sides relative_standard_uncertainty;  ///< of one packing; on one side 0 where the error has a known sign
    Part part = Part::numerical;
    Evidence evidence = Evidence::measured;
    std::string origin;  ///< what it was found from
};
template <core::MembersOf<BudgetRow> Self, typename Visit>
void visit_members(Self& row, const Visit& visit) {
    visit("source", row.source);
    double wider = row.relative_standard_uncertainty.wider();
    visit("relative_standard_uncertainty", wider);
    visit("sides", row.relative_standard_uncertainty);
    visit("part", row.part);
    visit("evidence", row.evidence);
    visit("origin", row.origin);
}

/// Half widths of intervals of 95 % over standard uncertainties.
inline constexpr double coverage_factor = 1.96;

/// Standard uncertainty that two methods with their own intervals of 95 % (none: exact) leave unexplained, relative to the first value:
/// the variance between them beyond their own (DerSimonian & Laird 1986, two studies). Of each interval, the side that faces the other
/// value counts: the other side cannot explain the difference. 0 if they agree within their uncertainties.
[[nodiscard]] double between_methods(double value, const std::optional<core::Interval>& interval, double other_value,
                                     const std::optional<core::Interval>& other_interval);

/// Relative change of k from a relative change `change` of the solid volume, by the Kozeny-Carman function of the porosity,
/// eps^3 / (1 - eps)^2, at constant area per volume of the solid.
[[nodiscard]] double permeability_change(double porosity, double change);

}  // namespace porepack::uncertainty
