// Closed surfaces of the inner space of vessels, as triangles.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "geometry/triangle_wall.hpp"

namespace porepack::test {

/// A tube whose horizontal sections are regular polygons with `facets` sides and the area of circles of radius `radius(z)`, about
/// `middle(z)`; between the heights, straight.
inline geometry::TriangleMesh tube_mesh(
    int facets, const std::vector<double>& heights, const std::function<double(double)>& radius,
    const std::function<geometry::Vec3(double)>& middle = [](double z) { return geometry::Vec3(0.0, 0.0, z); }) {
    const double turn = 2.0 * std::numbers::pi / facets, wider = std::sqrt(turn / std::sin(turn));
    geometry::TriangleMesh mesh;
    for (const double z : heights)
        for (int n = 0; n < facets; ++n)
            mesh.points_m.push_back(middle(z) + wider * radius(z) * geometry::Vec3(std::cos(n * turn), std::sin(n * turn), 0.0));
    const auto add = [&](int a, int b, int c) { mesh.triangles.push_back({a, b, c}); };
    const int rings = static_cast<int>(heights.size());
    for (int k = 0; k + 1 < rings; ++k)
        for (int n = 0; n < facets; ++n) {
            const int here = k * facets + n, next = k * facets + (n + 1) % facets;
            add(here, next, next + facets);
            add(here, next + facets, here + facets);
        }
    for (int n = 1; n + 1 < facets; ++n) {
        add(0, n + 1, n);
        add((rings - 1) * facets, (rings - 1) * facets + n, (rings - 1) * facets + n + 1);
    }
    return mesh;
}

/// The space between two upright polygons, each with the area of its circle.
inline geometry::TriangleMesh annulus_mesh(int facets, double inner_radius, double outer_radius, double height) {
    const double turn = 2.0 * std::numbers::pi / facets, wider = std::sqrt(turn / std::sin(turn));
    geometry::TriangleMesh mesh;
    for (const double z : {0.0, height})
        for (const double radius : {outer_radius, inner_radius})
            for (int n = 0; n < facets; ++n)
                mesh.points_m.emplace_back(wider * radius * std::cos(n * turn), wider * radius * std::sin(n * turn), z);
    const auto add = [&](int a, int b, int c) { mesh.triangles.push_back({a, b, c}); };
    for (int n = 0; n < facets; ++n) {
        const int o = n, p = (n + 1) % facets, i = o + facets, j = p + facets, up = 2 * facets;
        add(o, p, p + up);
        add(o, p + up, o + up);
        add(j, i, i + up);
        add(j, i + up, j + up);
        add(o, i, j);  // floor
        add(o, j, p);
        add(o + up, p + up, j + up);  // opening
        add(o + up, j + up, i + up);
    }
    return mesh;
}

}  // namespace porepack::test
