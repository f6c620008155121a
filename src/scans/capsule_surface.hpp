// The surface of a capsule as seen from a point; only for the sources of this folder.
#pragma once

#include <algorithm>

#include "shapes/capsule.hpp"

namespace porepack::scans {

/// Nearest to the point.
struct Surface {
    double distance = 1e300;  ///< negative inside
    shapes::Vec3 normal = shapes::Vec3::UnitZ(), axis_point = shapes::Vec3::Zero();
    double curvature = 0.0;  ///< mean
};

[[nodiscard]] inline Surface surface_of(const shapes::Capsule& capsule, const shapes::Vec3& x) {
    const shapes::Vec3 axis = capsule.b - capsule.a;
    const double length2 = axis.squaredNorm(), along = length2 > 0.0 ? (x - capsule.a).dot(axis) / length2 : 0.0;
    Surface found;
    found.axis_point = capsule.a + std::clamp(along, 0.0, 1.0) * axis;
    const shapes::Vec3 away = x - found.axis_point;
    const double distance = away.norm();
    if (distance > 1e-12) found.normal = away / distance;
    found.distance = distance - capsule.radius;
    // The mean of the principal curvatures: 1/r and 0 on the cylinder, 1/r twice on a cap.
    found.curvature = (length2 > 0.0 && along > 0.0 && along < 1.0 ? 0.5 : 1.0) / capsule.radius;
    return found;
}

}  // namespace porepack::scans
