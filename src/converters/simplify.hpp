// A closed surface with fewer triangles (CGAL).
#pragma once

#include <optional>

#include "io/stl.hpp"

namespace porepack::converters {

/// The part of the surface with the most triangles, with at most so many: edges are collapsed (Lindstrom and Turk). Nothing where the
/// surface is not manifold, or the result is not closed, crosses itself, or has no volume.
[[nodiscard]] std::optional<geometry::TriangleSurface> largest_part(const geometry::TriangleSurface& surface, long faces);

}  // namespace porepack::converters
