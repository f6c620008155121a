#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "converters/cgal_mesh.hpp"
#include "converters/surface.hpp"
#include "converters/uses.hpp"

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;

SurfaceMeasures measure_surface(const TriangleSurface& surface) {
    SurfaceMeasures measures;
    std::vector<Point> points;
    points.reserve(surface.points.size());
    Vec3 about = Vec3::Zero();
    for (const auto& p : surface.points) about += Vec3(p[0], p[1], p[2]) / static_cast<double>(surface.points.size());
    for (const auto& p : surface.points) points.emplace_back(p[0] - about.x(), p[1] - about.y(), p[2] - about.z());

    // Tetrahedra from the middle to every triangle: exact for polyhedra.
    Vec3 first = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const auto& triangle : surface.triangles) {
        Vec3 corner[3];
        for (std::size_t c = 0; c < 3; ++c) {
            const Point& p = points[static_cast<std::size_t>(triangle[c])];
            corner[c] = Vec3(p.x(), p.y(), p.z());
        }
        const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        const double volume = corner[0].dot(normal) / 6.0;
        const Vec3 sum = corner[0] + corner[1] + corner[2];
        measures.area_m2 += 0.5 * normal.norm();
        measures.volume_m3 += volume;
        first += volume * sum / 4.0;
        Eigen::Matrix3d squares = sum * sum.transpose();
        for (const Vec3& p : corner) squares += p * p.transpose();
        second += volume / 20.0 * squares;
    }
    const Vec3 centre = first / measures.volume_m3;
    second -= measures.volume_m3 * centre * centre.transpose();
    measures.centre_of_mass_m = about + centre;
    measures.inertia_per_density_m5 = second.trace() * Eigen::Matrix3d::Identity() - second;
    measures.sphericity = std::cbrt(36.0 * std::numbers::pi * measures.volume_m3 * measures.volume_m3) / measures.area_m2;

    Mesh hull;
    CGAL::convex_hull_3(points.begin(), points.end(), hull);
    measures.hull_volume_m3 = pmp::volume(hull);
    measures.hull_area_m2 = pmp::area(hull);
    for (const auto v : hull.vertices()) {
        const Point& p = hull.point(v);
        const Vec3 x(p.x(), p.y(), p.z());
        measures.bounding_radius_m = std::max(measures.bounding_radius_m, (x - centre).norm());
        for (const auto w : hull.vertices()) {
            const Point& q = hull.point(w);
            measures.maximum_feret_diameter_m = std::max(measures.maximum_feret_diameter_m, (x - Vec3(q.x(), q.y(), q.z())).norm());
        }
    }
    return measures;
}

}  // namespace porepack::converters
