// A grain's shape as points: what is compared with an image.
#pragma once

#include <vector>

#include "shapes/shape.hpp"

namespace porepack::scans {

struct Pose {
    shapes::Vec3 position_m = shapes::Vec3::Zero();  ///< of the origin of the shape's frame
    shapes::Quaternion orientation = shapes::Quaternion::Identity();
};

/// Steps of least squares: translation, then rotation vector about the position.
using Step = Eigen::Matrix<double, 6, 1>;
using StepMatrix = Eigen::Matrix<double, 6, 6>;
[[nodiscard]] Pose moved_by(const Pose& pose, const Step& step);

/// The shape's capsules in the world.
[[nodiscard]] std::vector<shapes::Capsule> placed(const std::vector<shapes::Capsule>& capsules, const Pose& pose);

/// Largest distance of a capsule's end from the same end of the nearest capsule of the other grain, in either order: 0 for poses that
/// differ by a rotation that maps the shape onto itself.
[[nodiscard]] double largest_difference_m(const std::vector<shapes::Capsule>& first, const std::vector<shapes::Capsule>& second);

struct ShapePoints {
    struct AxisPoint {
        shapes::Vec3 point;
        double radius_m;
    };
    std::vector<shapes::Capsule> capsules;
    std::vector<AxisPoint> axis;               ///< along the capsules' axes, 0.7 radii apart, the farthest from the anchor first
    std::vector<shapes::Vec3> surface;         ///< evenly on the exposed surface
    shapes::Vec3 anchor;                       ///< the deepest point of axes and centre
    double anchor_depth_m = 0.0;               ///< its distance to the surface
    std::vector<shapes::Vec3> ends;            ///< of capsules, each once
    std::vector<shapes::Vec3> different_ends;  ///< those that the shape's symmetry does not make equal
    double thinnest_radius_m = 0.0;
    double reach_m = 0.0;    ///< farthest point from the origin
    double volume_m3 = 0.0;  ///< by lines
};
[[nodiscard]] ShapePoints points_of(const shapes::Shape& shape);

/// Rotations about `anchor`, such that every other one differs by at most about `step_m` at the ends of the capsules from one of them;
/// rotations that the shape's symmetry makes equal occur once. By super-Fibonacci spirals (Alexa 2022).
[[nodiscard]] std::vector<shapes::Quaternion> rotations_of(const ShapePoints& shape, const shapes::Vec3& anchor, double step_m);

}  // namespace porepack::scans
