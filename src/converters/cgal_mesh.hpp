// The mesh type of this folder and its conversion; only for sources that include CGAL.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <optional>

#include "io/stl.hpp"

namespace porepack::converters {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

/// Nothing when the triangles are not manifold.
[[nodiscard]] std::optional<Mesh> mesh_of(const geometry::TriangleSurface& surface);
/// Adds a triangle mesh (without removed elements) to a surface.
void append(geometry::TriangleSurface& surface, const Mesh& mesh);

}  // namespace porepack::converters
