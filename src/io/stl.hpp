// Triangle surfaces in STL files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "geometry/triangle_surface.hpp"

namespace porepack::io {

/// Binary STL, single precision (by the format); the header names the unit. A failed write leaves no file.
void write_stl(const core::Path& path, const TriangleSurface& surface, const std::string& header = "porepack; unit: metre");

/// ASCII STL with one `solid` per region; `region` by triangle. OpenFOAM makes a separate patch of each.
void write_stl_regions(const core::Path& path, const TriangleSurface& surface, const std::vector<int>& region,
                       const std::vector<std::string>& names);
/// Binary PLY in double precision.
void write_ply(const core::Path& path, const TriangleSurface& surface, const std::string& comment = "unit: metre");
/// VTK polygons for ParaView, double precision.
void write_vtp(const core::Path& path, const TriangleSurface& surface);

using Line = std::vector<std::array<double, 3>>;
/// Lines that lead from one end of a section to the other.
struct Paths {
    std::vector<Line> lines;
    int axis = 2;  ///< normal to the ends
};
/// VTK lines for ParaView, double precision, with cell data `length_m` and `tortuosity` (length over the distance of the ends).
void write_vtp(const core::Path& path, const Paths& paths);

/// Binary or ASCII. `unit_m` scales to metres. Triangles with two equal corners in single precision are left out, with a warning.
/// Throws UserError: missing, empty, incomplete (with the bytes expected), NaN (with the triangle), not an STL file.
[[nodiscard]] TriangleSurface read_stl(const core::Path& path, double unit_m = 1.0);

}  // namespace porepack::io
