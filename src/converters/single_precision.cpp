#include "converters/single_precision.hpp"
#include "converters/uses.hpp"

#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

template <typename Real>
using Triangle = std::array<std::array<Real, 3>, 3>;

template <typename Real>
Triangle<Real> triangle_of(const Mesh& mesh, Mesh::Face_index face) {
    constexpr Real zero = 0;  // no minus zero
    Triangle<Real> triangle;
    std::size_t c = 0;
    for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) {
        const Point& p = mesh.point(v);
        triangle[c++] = {static_cast<Real>(p.x()) + zero, static_cast<Real>(p.y()) + zero, static_cast<Real>(p.z()) + zero};
    }
    return triangle;
}

template <typename Real>
TriangleSurface in_order(const std::vector<Triangle<Real>>& triangles) {
    std::vector<std::pair<std::array<Real, 3>, std::uint32_t>> corners;
    corners.reserve(3 * triangles.size());
    for (const auto& triangle : triangles)
        for (const auto& corner : triangle) corners.emplace_back(corner, static_cast<std::uint32_t>(corners.size()));
    std::sort(corners.begin(), corners.end());
    TriangleSurface result;
    std::vector<int> number(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto& [p, place] = corners[i];
        if (i == 0 || p != corners[i - 1].first) result.points.push_back({p[0], p[1], p[2]});
        number[place] = static_cast<int>(result.points.size()) - 1;
    }
    result.triangles.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        std::array<int, 3> triangle{number[3 * t], number[3 * t + 1], number[3 * t + 2]};
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
        result.triangles.push_back(triangle);
    }
    std::sort(result.triangles.begin(), result.triangles.end());
    return result;
}

}  // namespace

std::optional<Facet> facet_of(const Mesh& mesh, Mesh::Face_index face) {
    Facet facet = triangle_of<float>(mesh, face);
    std::rotate(facet.begin(), std::min_element(facet.begin(), facet.end()), facet.end());
    if (facet[0] == facet[1] || facet[1] == facet[2] || facet[2] == facet[0]) return std::nullopt;
    return facet;
}

Facets facets_of(const Mesh& mesh) {
    Facets facets;
    facets.reserve(mesh.number_of_faces());
    for (const auto face : mesh.faces())
        if (const auto facet = facet_of(mesh, face)) facets.push_back(*facet);
    return facets;
}

TriangleSurface surface_of(const Facets& facets) {
    return in_order(facets);
}

Mesh without_slivers(const Mesh& mesh, double smallest, const std::function<bool(const Point&)>& concerned) {
    constexpr double flat = 160.0 / 180.0 * std::numbers::pi;  // largest angle of a triangle that may stay
    constexpr double long_to_short = 4.0;                      // edges of a triangle that may stay
    std::vector<Triangle<double>> triangles;
    for (const auto face : mesh.faces()) triangles.push_back(triangle_of<double>(mesh, face));
    auto result = mesh_of(in_order(triangles));  // what is collapsed first decides what is left
    if (!result) return mesh;
    std::vector<Mesh::Face_index> faces;
    for (const auto face : result->faces()) {
        const auto corners = vertices_around_face(result->halfedge(face), *result);
        if (std::any_of(corners.begin(), corners.end(), [&](Mesh::Vertex_index v) { return concerned(result->point(v)); }))
            faces.push_back(face);
    }
    pmp::experimental::remove_almost_degenerate_faces(faces, *result, std::cos(flat), long_to_short, smallest,
                                                      CGAL::parameters::flip_triangle_height_threshold(smallest));
    result->collect_garbage();
    return std::move(*result);
}

}  // namespace porepack::converters
