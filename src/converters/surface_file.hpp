// Surfaces of users: STL, PLY and OBJ files.
#pragma once

#include "io/stl.hpp"

namespace porepack::converters {

/// A file whose name ends as one of a surface: .stl, .ply, .obj.
[[nodiscard]] bool is_surface_file(const core::Path& path);

/// Binary or ASCII STL and PLY, or OBJ; `unit_m` scales to metres. Polygons are divided into triangles from their first corner; points at
/// the same place become one. Colours, normals and textures are left out. Throws UserError: missing, empty, incomplete, no number, an
/// index without a point, another format.
[[nodiscard]] geometry::TriangleSurface read_surface(const core::Path& path, double unit_m = 1.0);

}  // namespace porepack::converters
