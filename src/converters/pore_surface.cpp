// The boundary of the pore space inside the container, in named regions, and grains clipped by two planes.
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "converters/mesh_intersections.hpp"
#include "converters/single_precision.hpp"
#include "converters/surface.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

Mesh sound_mesh_of(const TriangleSurface& surface) {
    auto mesh = mesh_of(surface);
    if (!mesh) throw NumericalError("the grains' surface is not manifold");
    return std::move(*mesh);
}

// A prism over a polygon in the plane.
Mesh prism(const std::vector<std::array<double, 2>>& base, double z0, double z1) {
    Mesh mesh;
    std::vector<Mesh::Vertex_index> low, high;
    for (const auto& p : base) {
        low.push_back(mesh.add_vertex(Point(p[0], p[1], z0)));
        high.push_back(mesh.add_vertex(Point(p[0], p[1], z1)));
    }
    const std::size_t n = base.size();
    for (std::size_t i = 0; i < n; ++i) mesh.add_face(low[i], low[(i + 1) % n], high[(i + 1) % n], high[i]);
    mesh.add_face(high);
    std::reverse(low.begin(), low.end());
    mesh.add_face(low);
    pmp::triangulate_faces(mesh);
    return mesh;
}

}  // namespace

TriangleSurface clip_surface(const TriangleSurface& surface, const Section& section) {
    Mesh grains = sound_mesh_of(surface);
    Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
    for (const auto& p : surface.points) {
        low = low.cwiseMin(Vec3(p[0], p[1], p[2]));
        high = high.cwiseMax(Vec3(p[0], p[1], p[2]));
    }
    const Vec3 margin = 0.1 * (high - low);
    Mesh slab = prism({{low.x() - margin.x(), low.y() - margin.y()},
                       {high.x() + margin.x(), low.y() - margin.y()},
                       {high.x() + margin.x(), high.y() + margin.y()},
                       {low.x() - margin.x(), high.y() + margin.y()}},
                      section.z0_m, section.z1_m);
    const auto inside = boolean_of(Boolean::intersect, grains, slab);
    if (!inside) throw NumericalError("CGAL cannot clip the grains", {.fix = "move the section slightly"});
    // Where a plane passes close to a corner, it cuts edges at points that single precision cannot hold apart; OpenFOAM, too, merges points
    // that are as close as this.
    constexpr double steps = 20.0 * 6e-8;  // of single precision, relative
    const double smallest = steps * std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    const Mesh apart = without_slivers(*inside, smallest, [&](const Point& p) {
        return std::min(std::abs(p.z() - section.z0_m), std::abs(p.z() - section.z1_m)) < smallest;
    });
    const TriangleSurface clipped = surface_of(facets_of(apart));
    if (const SurfaceCheck check = check_surface(clipped); !check.fault.empty())
        throw NumericalError("the clipped grains are not one closed surface in single precision: " + check.fault,
                             {.fix = "move the section slightly"});
    return clipped;
}

PoreSurface make_pore_surface(const TriangleSurface& grains_surface, const Container& container, const Section& section,
                              double deviation_m) {
    if (container.any_periodic()) throw UserError("a periodic cell has no inlet, outlet or wall", {.fix = "use the grains alone"});
    vessels::require_prism(container, "the surface of the pore space");
    const auto outlines = container.vessel().outlines(deviation_m);
    Mesh grains = sound_mesh_of(grains_surface), space = prism(outlines.front(), section.z0_m, section.z1_m);
    const double beyond = 0.1 * section.length();  // holes go through both ends
    for (std::size_t hole = 1; hole < outlines.size(); ++hole) {
        const auto corners = std::vector(outlines[hole].rbegin(), outlines[hole].rend());
        Mesh core = prism(corners, section.z0_m - beyond, section.z1_m + beyond);
        const auto around = boolean_of(Boolean::subtract, space, core);
        if (!around) throw NumericalError("CGAL cannot subtract the inner wall from the container", {.fix = "move the section slightly"});
        space = *around;
    }
    const auto pores = boolean_of(Boolean::subtract, space, grains);
    if (!pores)
        throw NumericalError("CGAL cannot subtract the grains from the container",
                             {.fix = "change the section or surface_deviation_m slightly"});
    PoreSurface result;
    append(result.surface, *pores);
    // A triangle lies on a plane of the section, or on one of the wall's planes, or is a grain's.
    const double slack = 1e-7 * (section.length() + container.high().norm());
    const auto on_side = [&](const std::array<std::array<double, 3>, 3>& corners, const std::array<double, 2>& p,
                             const std::array<double, 2>& q) {
        const double length = std::hypot(q[0] - p[0], q[1] - p[1]);
        return std::all_of(corners.begin(), corners.end(), [&](const auto& c) {
            return std::abs((c[0] - p[0]) * (q[1] - p[1]) - (c[1] - p[1]) * (q[0] - p[0])) < slack * length;
        });
    };
    const auto on_wall = [&](const std::array<std::array<double, 3>, 3>& corners) {
        for (const auto& line : outlines)
            for (std::size_t i = 0; i < line.size(); ++i)
                if (on_side(corners, line[i], line[(i + 1) % line.size()])) return true;
        return false;
    };
    for (const auto& triangle : result.surface.triangles) {
        std::array<std::array<double, 3>, 3> corners{};
        bool low = true, high = true;
        for (std::size_t c = 0; c < 3; ++c) {
            corners[c] = result.surface.points[static_cast<std::size_t>(triangle[c])];
            low = low && std::abs(corners[c][2] - section.z0_m) < slack;
            high = high && std::abs(corners[c][2] - section.z1_m) < slack;
        }
        result.region.push_back(low ? 0 : high ? 1 : on_wall(corners) ? 2 : 3);
    }
    return result;
}

}  // namespace porepack::converters
