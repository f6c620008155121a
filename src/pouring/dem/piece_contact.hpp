// The contact of one piece of a grain with faces with another body's surface.
//
// Two grains repel each other with one potential, (s_n/4) O^2. O is a mean of all overlaps between the two: the sum of o^8 over corners,
// and of the integral of o^8 over edges and rims per tenth of the grain's thickness, to the power 1/8. It is smooth, and hardly depends on
// how finely a face is divided: corner against face, O is the overlap; face against face, up to 1.7 times it. The distance from the
// surface, inside the grain down to the middle of its thinnest part, tells how deep a point is and which way leads out, also where the
// rounded edges have passed through each other.
#pragma once

#include "pouring/dem/contact_pieces.hpp"
#include "shapes/point_row.hpp"

namespace porepack::pouring::dem {

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

}  // namespace porepack::pouring::dem
