// Sixteen places of a contact piece at once.
#pragma once

#include "geometry/vessel.hpp"
#include "pouring/dem/contact_pieces.hpp"
#include "shapes/point_row.hpp"

namespace porepack::pouring::dem {

/// Places along a piece: points, tangents (unit vectors), and length per parameter. `s` is given for all sixteen, also where fewer points
/// count.
struct PlaceRow {
    shapes::Row s, speed;
    shapes::PointRow points, tangents;
};
void place(const ContactPiece& piece, PlaceRow& row);

/// No place of the piece is nearer, whose ends are the first and the last place.
[[nodiscard]] double bound_between(const PlaceRow& row, const shapes::Row& distance);

/// From a plane whose distance is `offset` at the origin.
void plane_distances(const shapes::Vec3& normal, double offset, const shapes::PointRow& points, shapes::DistanceRow& found);
/// From a round wall, of points in a frame with this pose.
void round_distances(const Eigen::Matrix3d& turn, const shapes::Vec3& origin, const geometry::VesselWalls::Round& wall,
                     const shapes::PointRow& points, shapes::DistanceRow& found);

/// Of the distance, per length along the piece.
void find_slopes(const PlaceRow& row, const shapes::DistanceRow& found, shapes::Row& slopes);

/// The sum over parts of a piece of what a shift and a turn of the piece change.
struct ContactSum {
    shapes::Vec3 about;  ///< a point near the contact
    shapes::Vec3 push = shapes::Vec3::Zero(), at = shapes::Vec3::Zero(), moment = shapes::Vec3::Zero();
    double potential = 0.0, weight = 0.0;

    void add(const shapes::Vec3& force, const shapes::Vec3& from_about) {
        push += force;
        moment += from_about.cross(force);
    }
};
/// `weights`: of o^7, 0 where fewer points count.
void add_row(const PlaceRow& row, const shapes::DistanceRow& found, const shapes::Row& weights, double radius, ContactSum& sum);

}  // namespace porepack::pouring::dem
