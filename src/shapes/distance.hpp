// How near two grains are, of any shapes: corners, edges, rims and axes of each against the distance from the other.
#pragma once

#include <functional>
#include <vector>

#include "shapes/shape.hpp"

namespace porepack::shapes {

/// A shape in its place; refers to the shape.
struct PlacedShape {
    const Shape& shape;
    Vec3 position_m = Vec3::Zero();                   ///< of the origin of the shape's frame
    Quaternion orientation = Quaternion::Identity();  ///< from the shape's frame

    [[nodiscard]] Vec3 to_shape(const Vec3& point) const { return orientation.conjugate() * (point - position_m); }
    [[nodiscard]] Vec3 to_world(const Vec3& point) const { return position_m + orientation * point; }
};

/// From the grain's surface; see RoundedBody::distance(), and signed_distance() of capsules. Enclosed voids are not looked at.
[[nodiscard]] double signed_distance(const PlacedShape& grain, const Vec3& point);
/// The same; `outward` becomes the direction in which the distance grows (unit vector).
[[nodiscard]] double signed_distance(const PlacedShape& grain, const Vec3& point, Vec3& outward);
/// The same of capsules, in their own frame.
[[nodiscard]] double signed_distance(const std::vector<Capsule>& capsules, const Vec3& point, Vec3& outward);
/// Exact, along the axes of the world.
[[nodiscard]] Bounds bounds_of(const PlacedShape& grain);

/// Balls that lie in the grain and touch its surface: at corners, and at 16 places of each edge, rim and capsule.
struct Ball {
    Vec3 centre;
    double radius;
};
[[nodiscard]] std::vector<Ball> balls_of(const PlacedShape& grain);

struct Nearest {
    double gap_m = 0.0;           ///< between the surfaces; negative: how deep they overlap
    Vec3 point = Vec3::Zero();    ///< in the middle of the gap
    Vec3 normal = Vec3::UnitZ();  ///< unit vector from the first grain to the second
};
/// The place where two grains are nearest, or overlap most; `gap_m` = `beyond_m` where they are farther apart than that. To about 1e-9 of
/// their size. What lies in the hole of a ring is near its wall, not its axis.
[[nodiscard]] Nearest nearest(const PlacedShape& first, const PlacedShape& second, double beyond_m);

/// How far the grain reaches beyond the zero of a function that is the distance from walls, positive between them; negative: how far it
/// stays away. Exact for walls that are flat or curved around the grain.
[[nodiscard]] double reach_beyond(const PlacedShape& grain, const std::function<double(const Vec3&)>& wall_distance);

}  // namespace porepack::shapes
