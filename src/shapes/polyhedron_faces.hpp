// Faces and edges of a convex polyhedron: what its rounded body is made of.
#pragma once

#include <array>
#include <vector>

#include "geometry/vector.hpp"

namespace porepack::shapes {

using geometry::Vec3;

struct Face {
    std::vector<int> corners;
    Vec3 normal;
    double height;                   // of its plane along the normal
    std::vector<Vec3> outwards;      // unit vector in the plane, out of the side from corner i to the next
    std::vector<std::size_t> edges;  // number of that side's edge
};

struct Edge {
    int a, b;
    std::array<std::size_t, 2> faces;
    Vec3 normal_a, normal_b;  // of its two faces
    Vec3 out_a, out_b;        // of these, out of the side at this edge
};

/// The face with its plane. Throws UserError where it is not flat or not convex (1e-9 of `size`).
[[nodiscard]] Face plane_face(const std::vector<Vec3>& corners, const std::vector<int>& list, double size);
/// Throws UserError unless each side of a face is a side of one other, the other way.
[[nodiscard]] std::vector<Edge> edges_of(const std::vector<Face>& faces);
/// The middle of the largest ball between the faces: the mean of the corners, or a place where the nearest face is farther away.
[[nodiscard]] Vec3 middle_of_largest_ball(const std::vector<Face>& faces, const std::vector<Vec3>& corners);

}  // namespace porepack::shapes
