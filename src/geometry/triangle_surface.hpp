// A closed surface of triangles, as files hold it.
#pragma once

#include <array>
#include <vector>

namespace porepack::inline geometry {

/// Triangles with shared corners, counter-clockwise from outside: points with identical coordinates are one point. In metres.
struct TriangleSurface {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<int, 3>> triangles;
};

}  // namespace porepack::inline geometry
