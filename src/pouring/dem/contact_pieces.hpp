// Grains with faces in the DEM: pieces of the curves along which they touch.
#pragma once

#include <vector>

#include "shapes/shape.hpp"

namespace porepack::pouring::dem {

/// One point of a curve, or a stretch of it. In the shape's frame.
struct ContactPiece {
    enum class Kind { point, segment, arc, axis };
    Kind kind = Kind::point;
    shapes::Vec3 start = shapes::Vec3::Zero();  ///< the point; one end; the centre of an arc's circle
    shapes::Vec3 along = shapes::Vec3::Zero();  ///< from end to end of a segment or an axis
    shapes::Vec3 u = shapes::Vec3::Zero(),
                 v = shapes::Vec3::Zero();  ///< of an arc: the circle's radii to its beginning, and at right angles to that
    double rim_radius = 0.0;
    double half_tangent = 0.0;  ///< of an arc: tangent of half its angle
    double length = 0.0;
    double radius = 0.0;               ///< of the ball, or the disc of an axis
    double hole_radius = 0.0;          ///< of an axis
    double per_length = 0.0;           ///< the integral over the piece is taken per this length
    double before = 0.0, after = 0.0;  ///< lengths of the axis before and after this piece of it
    double taper = 0.0;                ///< an axis loses its weight within this length of its ends, where the rims begin to touch

    /// At 0 to 1; on an arc the parameter is the tangent of half the angle from its beginning, so that no sine is needed; `tangent` (unit
    /// vector) only where it is not null.
    [[nodiscard]] shapes::Vec3 at(double s, shapes::Vec3* tangent = nullptr) const;
    /// Length per parameter.
    [[nodiscard]] double speed(double s) const;
    [[nodiscard]] ContactPiece moved(const Eigen::Matrix3d& turn_by, const shapes::Vec3& shift) const;
};

/// Those of each shape; edges no longer than a quarter of the smallest grain, nor than six times the thinnest part of a grain that is not
/// convex; axes are whole where all shapes are convex.
[[nodiscard]] std::vector<std::vector<ContactPiece>> pieces_of(const std::vector<shapes::Shape>& shapes);
[[nodiscard]] bool is_convex(const shapes::Shape& shape);

}  // namespace porepack::pouring::dem
