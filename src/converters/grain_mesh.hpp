// Closed meshes of single grains, and their union; only for the sources of this folder that include CGAL.
#pragma once

#include "converters/cgal_mesh.hpp"
#include "shapes/shape.hpp"

namespace porepack::converters {

[[nodiscard]] inline Point to_point(const shapes::Vec3& v) {
    return {v.x(), v.y(), v.z()};
}
[[nodiscard]] inline shapes::Vec3 to_vector(const Point& p) {
    return {p.x(), p.y(), p.z()};
}

/// A shape as one closed mesh in its frame, within `deviation_m` of the exact surface and of the exact volume per capsule.
/// `thinner_m` is taken off everywhere. `variant` counts the attempts: each has different corners. Enclosed voids are left out
/// where they count as solid. Throws UserError when a capsule would need more than 512 corners around its axis, NumericalError when CGAL
/// cannot unite the capsules.
[[nodiscard]] Mesh grain_mesh(const shapes::Shape& shape, double deviation_m, double thinner_m, int variant);

/// A copy at another pose.
[[nodiscard]] Mesh moved_mesh(const Mesh& mesh, const shapes::Vec3& position, const shapes::Quaternion& orientation);

/// Replaces `all` by its union with `part`; `part` is used up. Throws NumericalError when CGAL cannot unite them.
void unite_into(Mesh& all, Mesh& part);

}  // namespace porepack::converters
