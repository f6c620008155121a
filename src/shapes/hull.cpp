// Convex hull of a union of capsules: the hull of their end spheres.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <cmath>
#include <numbers>

#include "shapes/shape.hpp"

namespace porepack {

double hull_volume(const std::vector<Capsule>& capsules) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    // Hulls of points on the end spheres are too small by about 1/points: two sizes, then extrapolation.
    const double size = (bounds_of(capsules).high - bounds_of(capsules).low).norm();
    const auto sampled = [&](int points) {
        std::vector<Kernel::Point_3> cloud;
        const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
        int turn = 0;
        for (const auto& capsule : capsules)
            for (const Vec3& centre : {capsule.a, capsule.b}) {
                ++turn;  // every sphere's points are turned by another angle: no coplanar facets
                for (int i = 0; i < points; ++i) {
                    const double z = 1.0 - (2.0 * i + 1.0) / points;
                    const double rho = std::sqrt(1.0 - z * z);
                    const Vec3 x =
                        (centre + capsule.radius * Vec3(rho * std::cos(golden * i + turn), rho * std::sin(golden * i + turn), z)) / size;
                    cloud.emplace_back(x.x(), x.y(), x.z());
                }
            }
        CGAL::Surface_mesh<Kernel::Point_3> hull;
        CGAL::convex_hull_3(cloud.begin(), cloud.end(), hull);
        return CGAL::Polygon_mesh_processing::volume(hull) * size * size * size;
    };
    const double coarse = sampled(1000);
    const double fine = sampled(4000);
    return fine + (fine - coarse) / 3.0;
}

}  // namespace porepack
