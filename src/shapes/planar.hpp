// Parts of a line within an upright cylinder, and between two heights.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/interval.hpp"
#include "geometry/vector.hpp"

namespace porepack::shapes {

/// The whole line, where it runs within; nothing where it touches only.
[[nodiscard]] inline std::optional<core::Interval> within_heights(const geometry::Vec3& origin, const geometry::Vec3& direction, double low,
                                                                  double high) {
    if (std::abs(direction.z()) < 1e-14) {
        if (origin.z() <= low || origin.z() >= high) return std::nullopt;
        return core::Interval{-1e300, 1e300};
    }
    const double t0 = (low - origin.z()) / direction.z(), t1 = (high - origin.z()) / direction.z();
    return core::Interval{std::min(t0, t1), std::max(t0, t1)};
}

/// About the axis z.
[[nodiscard]] inline std::optional<core::Interval> within_circle(const geometry::Vec3& origin, const geometry::Vec3& direction,
                                                                 double radius) {
    const double a = direction.head<2>().squaredNorm(), to_middle = -direction.head<2>().dot(origin.head<2>());
    if (a < 1e-28) {
        if (origin.head<2>().squaredNorm() >= radius * radius) return std::nullopt;
        return core::Interval{-1e300, 1e300};
    }
    const double middle = to_middle / a;
    const double half2 = (radius * radius - (origin.head<2>() + middle * direction.head<2>()).squaredNorm()) / a;
    if (half2 <= 0.0) return std::nullopt;
    const double half = std::sqrt(half2);
    return core::Interval{middle - half, middle + half};
}

}  // namespace porepack::shapes
