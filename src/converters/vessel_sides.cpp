// The sides of vessels as triangles.
#include <cmath>
#include <numbers>

#include "converters/surface.hpp"
#include "converters/uses.hpp"
#include "geometry/triangle_wall.hpp"

namespace porepack::converters {

TriangleSurface sides_of(const Container& container, double top_m) {
    TriangleSurface sides;
    const auto walls = container.vessel().walls();
    if (!walls) return sides;
    const auto add = [&](const TriangleMesh& mesh) {
        const int first = static_cast<int>(sides.points.size());
        for (const Vec3& point : mesh.points_m) sides.points.push_back({point.x(), point.y(), point.z()});
        for (const auto& [a, b, c] : mesh.triangles) sides.triangles.push_back({first + a, first + b, first + c});
    };
    for (const auto& wall : walls->round) {
        constexpr int facets = 96;
        TriangleMesh mesh;
        for (const double z : {container.low().z(), top_m})
            for (int n = 0; n < facets; ++n) {
                const double turn = 2.0 * std::numbers::pi * n / facets, radius = wall.radius_m + wall.slope * z;
                mesh.points_m.emplace_back(radius * std::cos(turn), radius * std::sin(turn), z);
            }
        for (int n = 0; n < facets; ++n) {
            const int next = (n + 1) % facets;
            mesh.triangles.push_back({n, next, next + facets});
            mesh.triangles.push_back({n, next + facets, n + facets});
        }
        add(mesh);
    }
    if (walls->mesh != nullptr) add(walls->mesh->sides(container.low().z(), container.high().z()));
    return sides;
}

}  // namespace porepack::converters
