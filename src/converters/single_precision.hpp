// Meshes in the precision of the STL file, which holds coordinates as 32-bit floating-point numbers; only for the sources of this folder
// that include CGAL.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "converters/cgal_mesh.hpp"

namespace porepack::converters {

/// A triangle with its three corners, the smallest of them first.
using Facet = std::array<std::array<float, 3>, 3>;
using Facets = std::vector<Facet>;

/// Coordinates rounded to single precision; facets without area are left out.
[[nodiscard]] Facets facets_of(const Mesh& mesh);
/// Nothing when two corners of the face are the same point in single precision.
[[nodiscard]] std::optional<Facet> facet_of(const Mesh& mesh, Mesh::Face_index face);
/// Points that are equal become one. Points and triangles are sorted, because CGAL's order depends on the number of threads.
[[nodiscard]] geometry::TriangleSurface surface_of(const Facets& facets);

/// Edges shorter than `smallest` are collapsed, and triangles less high than it are flipped away: rounded to single precision, they could
/// cross each other. They come into being where two bodies meet, and where a plane cuts a body close to its corners. Only faces with a
/// corner for which `concerned` holds are changed. A mesh that is not manifold is returned as it is.
[[nodiscard]] Mesh without_slivers(
    const Mesh& mesh, double smallest, const std::function<bool(const Point&)>& concerned = [](const Point&) { return true; });

}  // namespace porepack::converters
