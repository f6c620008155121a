// Grains with faces in the DEM: pieces of the curves along which they touch, and the contact of one piece with another body's surface.
//
// Two grains repel each other with one potential, (s_n/4) O^2. O is a mean of all overlaps between the two: the sum of o^8 over corners,
// and of the integral of o^8 over edges and rims per tenth of the grain's thickness, to the power 1/8. It is smooth, and hardly depends on
// how finely a face is divided: corner against face, O is the overlap; face against face, up to 1.7 times it. The distance from the
// surface, inside the grain down to the middle of its thinnest part, tells how deep a point is and which way leads out, also where the
// rounded edges have passed through each other.
#pragma once

#include <vector>

#include "shapes/point_row.hpp"
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
/// convex; axes are whole where all shapes are convex. None at all without grains with faces.
[[nodiscard]] std::vector<std::vector<ContactPiece>> pieces_of(const std::vector<shapes::Shape>& shapes);
[[nodiscard]] bool is_convex(const shapes::Shape& shape);

struct PieceContact {
    double potential = 0.0;                       ///< its part of O^8
    double weight = 0.0;                          ///< by how much that part falls with a shift of the piece along `normal`, over 8
    double overlap = 0.0;                         ///< mean
    shapes::Vec3 normal = shapes::Vec3::UnitZ();  ///< of the force on the piece: out of the other body
    shapes::Vec3 at = shapes::Vec3::Zero();       ///< in the middle of the overlap
    double twist = 0.0;                           ///< torque on the piece about `normal` over the force, which no lever gives
};

/// What a piece may be in contact with: a grain, or a wall.
class Surface {
public:
    explicit Surface(bool convex) : convex_(convex) {}
    Surface(const Surface&) = delete;
    Surface& operator=(const Surface&) = delete;
    virtual ~Surface() = default;
    /// Negative inside; with the direction in which it grows (unit vector).
    virtual double distance(const shapes::Vec3& point, shapes::Vec3& outward) const = 0;
    /// The same of several points.
    virtual void distances(const shapes::PointRow& points, shapes::DistanceRow& found) const;
    [[nodiscard]] bool convex() const { return convex_; }

private:
    bool convex_;
};

/// False where the piece is not in contact; then `gap` is a lower bound of the gap, or 0.
[[nodiscard]] bool contact_of(const ContactPiece& piece, const Surface& surface, PieceContact& contact, double& gap);

/// Fraction of the stiffness that a contact has, given the sum of all potentials of the two bodies.
[[nodiscard]] double share_of(const PieceContact& contact, double sum_of_potentials);
/// Its part of O^2.
[[nodiscard]] double square_of(const PieceContact& contact, double sum_of_potentials);

/// Where overlaps exceed this fraction of the thinner grain's thickness the grains begin to pass through each other.
inline constexpr double deepest_overlap = 0.4;

}  // namespace porepack::pouring::dem
