// Triangle surfaces in STL files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack {

/// Triangles with shared corners: points that are equal to the last bit are one.
struct TriangleSurface {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<int, 3>> triangles;
};

/// Binary STL, single precision (the format's); the header names the unit. Whole or not at all.
void write_stl(const Path& path, const TriangleSurface& surface, const std::string& header = "porepack; unit: metre");

/// Binary or ASCII. `unit_m` scales to metres. Triangles that lost their area to single precision are left out.
/// Throws UserError: missing, empty, cut (with the bytes expected), NaN (with the triangle), not an STL.
[[nodiscard]] TriangleSurface read_stl(const Path& path, double unit_m = 1.0);

}  // namespace porepack
