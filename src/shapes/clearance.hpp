// Straight lines between capsules: intersections and clearance. Only for the sources of this folder.
#pragma once

#include <vector>

#include "shapes/capsule.hpp"

namespace porepack::shapes {

/// Does the segment from p to q pass through a capsule?
[[nodiscard]] bool blocked(const std::vector<Capsule>& capsules, const Vec3& p, const Vec3& q);

/// Clearance of the line from `origin` over the length `far`: its minimum distance to a surface, negative when it is blocked.
[[nodiscard]] double clearance(const std::vector<Capsule>& capsules, const Vec3& origin, const Vec3& direction, double far);

/// Searches for a straight line out of the grain: improves the 24 directions of largest clearance out of 512.
[[nodiscard]] bool ray_escapes(const std::vector<Capsule>& capsules, const Vec3& origin, double far);

/// A point with a larger distance to the surfaces, or `point` itself where none is found: the free ball around a point extends to the
/// nearest surface, and the best of 26 points on the ball is taken.
[[nodiscard]] Vec3 wider_place(const std::vector<Capsule>& capsules, const Vec3& point);

}  // namespace porepack::shapes
