// Points, rotations and boxes. Lengths in metres, or in any other unit that is used throughout.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace porepack::inline geometry {

using Vec3 = Eigen::Vector3d;
/// Not over-aligned: Eigen's alignment would depend on the instruction set that a program is compiled for.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

/// From 0 to pi.
[[nodiscard]] inline double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// A box along the axes; empty at first.
struct Bounds {
    Vec3 low = Vec3::Constant(1e300);
    Vec3 high = Vec3::Constant(-1e300);
    /// Makes it hold a sphere.
    void add(const Vec3& centre, double radius) {
        low = low.cwiseMin(centre - Vec3::Constant(radius));
        high = high.cwiseMax(centre + Vec3::Constant(radius));
    }
};

}  // namespace porepack::inline geometry
