// A capsule (spherocylinder): all points within `radius` of the segment from a to b. A sphere has a = b.
// Lengths in metres, or in any other unit that is used throughout.
#pragma once

#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "geometry/vector.hpp"

namespace porepack::shapes {

using geometry::Bounds;
using geometry::Quaternion;
using geometry::Vec3;

/// Its axis from a to b and its radius, in one unit of length (metres in packings).
struct Capsule {
    Vec3 a = Vec3::Zero();
    Vec3 b = Vec3::Zero();
    double radius = 0.0;
};

/// Point of the capsule's axis that is closest to `point`.
[[nodiscard]] Vec3 closest_on_axis(const Capsule& capsule, const Vec3& point);
/// Distance to the surface, negative inside. Exact.
[[nodiscard]] double signed_distance(const Capsule& capsule, const Vec3& point);
/// Distance to the nearest surface of the union; exact outside, a lower bound of the depth inside.
[[nodiscard]] double signed_distance(const std::vector<Capsule>& capsules, const Vec3& point);
/// The part of the line origin + t direction (unit vector) inside the capsule; capsules are convex, so it is one interval.
[[nodiscard]] std::optional<core::Interval> line_interval(const Capsule& capsule, const Vec3& origin, const Vec3& direction);
/// Distance between two surfaces; negative when they overlap.
[[nodiscard]] double gap(const Capsule& first, const Capsule& second);

/// Makes the box hold the capsule.
void add(Bounds& bounds, const Capsule& capsule);
[[nodiscard]] Bounds bounds_of(const std::vector<Capsule>& capsules);

[[nodiscard]] Capsule moved(const Capsule& capsule, const Vec3& position, const Quaternion& orientation);

}  // namespace porepack::shapes
