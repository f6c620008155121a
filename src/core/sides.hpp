// The two sides of a value: intervals need not be symmetric about it.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::inline core {

/// A width below a value and one above it: the half widths of an interval, or one-sided standard uncertainties.
struct Sides {
    double below = 0.0;
    double above = 0.0;
    [[nodiscard]] double wider() const { return std::max(below, above); }
};
template <MembersOf<Sides> Self, typename Visit>
void visit_members(Self& sides, const Visit& visit) {
    visit("below", sides.below);
    visit("above", sides.above);
}
[[nodiscard]] inline Sides operator*(double factor, const Sides& sides) {
    return {factor * sides.below, factor * sides.above};
}

/// Half widths of an interval about `value`; 0 on a side on which the interval does not reach it.
[[nodiscard]] inline Sides half_widths(double value, const Interval& interval) {
    return {std::max(0.0, value - interval.low), std::max(0.0, interval.high - value)};
}
[[nodiscard]] inline Interval about(double value, const Sides& half_widths) {
    return {value - half_widths.below, value + half_widths.above};
}

/// Independent contributions, each side by itself: an error that can only lower a value widens no upper bound (docs/uncertainty.md).
[[nodiscard]] inline Sides in_quadrature(const Sides& one, const Sides& other) {
    return {std::hypot(one.below, other.below), std::hypot(one.above, other.above)};
}

/// The interval of `value` with an independent contribution. It contains `own`, whatever the rounding.
[[nodiscard]] inline Interval widened(const Interval& own, double value, const Sides& contribution) {
    const Interval wide = about(value, in_quadrature(half_widths(value, own), contribution));
    return {std::min(own.low, wide.low), std::max(own.high, wide.high)};
}

}  // namespace porepack::inline core
