// Grains from closed surfaces: what few faces and rounding change, holes, and surfaces that are refused.
#include "converters/grain_from_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "converters/grain_mesh.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "shapes/shape.hpp"
#include "support/basics.hpp"
#include "support/stones.hpp"

namespace porepack::converters {
namespace {

using core::UserError;
using shapes::Vec3;
using test::has;
using test::message_of;

TriangleSurface surface_of(const shapes::PolyhedronSize& size, double unit, const Vec3& shift) {
    TriangleSurface surface;
    for (const Vec3& x : size.corners_m) {
        const Vec3 moved = unit * x + shift;
        surface.points.push_back({moved.x(), moved.y(), moved.z()});
    }
    for (const auto& face : size.faces)
        for (std::size_t i = 1; i + 1 < face.size(); ++i) surface.triangles.push_back({face[0], face[i], face[i + 1]});
    return surface;
}

// A torus of 48 x 24 quadrilaterals.
TriangleSurface torus(double radius, double tube) {
    TriangleSurface surface;
    constexpr int n = 48, m = 24;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double u = 2.0 * std::numbers::pi * i / n, v = 2.0 * std::numbers::pi * j / m, away = radius + tube * std::cos(v);
            surface.points.push_back({away * std::cos(u), away * std::sin(u), tube * std::sin(v)});
        }
    const auto at = [&](int i, int j) { return i % n * m + j % m; };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            surface.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            surface.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return surface;
}

TEST(GrainFromMesh, MoreFacesComeNearerAndTheVolumeIsKept) {
    const TriangleSurface surface = surface_of(test::stone(4, 0.5, 5, 0.0), 0.01, {0.1, -0.2, 0.3});
    const double volume = measure_surface(surface).volume_m3, diameter = std::cbrt(6.0 * volume / std::numbers::pi);
    double before = 1.0;
    for (const long faces : {60, 120, 240}) {
        const MeshGrain grain = grain_from_mesh(surface, {.faces = faces}, "stone");
        EXPECT_NEAR(static_cast<double>(grain.faces), static_cast<double>(faces), 2.0);
        EXPECT_EQ(grain.faces_before, 5120);
        EXPECT_NEAR(grain.body->rounding() / diameter, 0.02, 4e-4);
        const shapes::ShapeMeasures m = shapes::measure({.id = "stone", .body = grain.body});
        EXPECT_NEAR(m.volume_m3 / volume, 1.0, 2e-6);
        EXPECT_LT(m.centre_of_mass_m.norm(), 1e-6 * diameter);
        EXPECT_LT(grain.rms_deviation_m, 0.65 * before) << faces;  // of second order: half for twice as many faces
        EXPECT_LT(grain.rms_deviation_m, grain.largest_deviation_m);
        before = grain.rms_deviation_m;
    }
    EXPECT_LT(before, 0.004 * diameter);
    const MeshGrain fine = grain_from_mesh(surface, {.deviation_m = 0.03 * diameter}, "stone");
    EXPECT_LE(fine.largest_deviation_m, 0.03 * diameter);
    EXPECT_LT(fine.faces, 400);
}

// Where a level set passes next to a point of its grid, it has triangles of any smallness, whose normals say nothing.
void put_tiny_triangle(shapes::PolyhedronSize& stone, int corner, double tiny) {
    std::map<int, int> next;  // around the corner
    std::vector<std::vector<int>> others;
    for (const auto& face : stone.faces) {
        const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), corner) - face.begin());
        if (at == 3)
            others.push_back(face);
        else
            next[face[(at + 1) % 3]] = face[(at + 2) % 3];
    }
    ASSERT_EQ(next.size(), 6U);
    std::vector<int> ring = {next.begin()->first};
    while (ring.size() < 6) ring.push_back(next.at(ring.back()));
    const Vec3 x = stone.corners_m[static_cast<std::size_t>(corner)], out = x.normalized();
    const int second = static_cast<int>(stone.corners_m.size());
    const int own[] = {corner, second, second + 1};
    stone.corners_m.resize(stone.corners_m.size() + 2);
    for (std::size_t n = 0; n < 3; ++n) {
        const Vec3 towards = (stone.corners_m[static_cast<std::size_t>(ring[2 * n + 1])] - x).normalized();
        stone.corners_m[static_cast<std::size_t>(own[n])] = x + tiny * (towards + 20.0 * static_cast<double>(n) * out);
    }
    stone.faces = others;
    for (std::size_t n = 0; n < 3; ++n) {
        const int a = ring[2 * n], b = ring[2 * n + 1], c = ring[(2 * n + 2) % 6];
        stone.faces.insert(stone.faces.end(), {{own[n], a, b}, {own[n], b, c}, {own[n], c, own[(n + 1) % 3]}});
    }
    stone.faces.push_back({own[0], own[1], own[2]});
}

TEST(GrainFromMesh, TinyTrianglesOfALevelSetDoNotMatter) {
    shapes::PolyhedronSize rough = test::stone(3, 0.4, 5, 0.0);
    const MeshGrain before = grain_from_mesh(surface_of(rough, 0.009, Vec3::Zero()), {.faces = 80}, "stone");
    for (const int corner : {100, 200, 300, 400}) put_tiny_triangle(rough, corner, 1e-7);
    const MeshGrain grain = grain_from_mesh(surface_of(rough, 0.009, Vec3::Zero()), {.faces = 80}, "stone");
    EXPECT_EQ(grain.faces, 80);
    EXPECT_LT(grain.largest_deviation_m, 1.5 * before.largest_deviation_m);  // other edges are collapsed first
}

TEST(GrainFromMesh, ABoxStaysABox) {
    const shapes::PolyhedronSize box = shapes::box_size({0.02, 0.01, 0.015}, 0.0);
    const MeshGrain grain = grain_from_mesh(surface_of(box, 1.0, {0, 0, 0}), {.faces = 12, .rounding_m = 3e-4}, "box");
    EXPECT_EQ(grain.faces, 12);
    EXPECT_LT(grain.largest_deviation_m, 3e-4);
    EXPECT_LT(grain.rms_deviation_m, 6e-5);
}

TEST(GrainFromMesh, AHoleStays) {
    const TriangleSurface surface = torus(0.01, 0.004);
    const MeshGrain grain = grain_from_mesh(surface, {.faces = 200}, "torus");
    EXPECT_GT(grain.body->distance(Vec3::Zero()), 0.004);
    EXPECT_NEAR(grain.body->thickness(), 0.008, 0.0012);
    // The surface of a grain without facets of its own: closed, near the exact one, with the hole.
    const shapes::Shape shape{.id = "torus", .body = grain.body};
    const Mesh mesh = grain_mesh(shape, 2e-4, 0.0, 0);
    TriangleSurface made;
    append(made, mesh);
    const SurfaceCheck check = check_surface(made);
    EXPECT_TRUE(check.fault.empty()) << check.fault;
    EXPECT_EQ(static_cast<long>(made.points.size()) - static_cast<long>(made.triangles.size()) / 2, 0);  // Euler's number of a torus
    EXPECT_NEAR(check.volume_m3 / grain.volume_m3, 1.0, 1e-4);
    for (const auto& triangle : made.triangles) {
        Vec3 middle = Vec3::Zero();
        for (const int i : triangle) {
            const auto& p = made.points[static_cast<std::size_t>(i)];
            EXPECT_LT(std::abs(grain.body->distance(Vec3(p[0], p[1], p[2]))), 1.41e-4);
            middle += Vec3(p[0], p[1], p[2]) / 3.0;
        }
        EXPECT_LT(std::abs(grain.body->distance(middle)), 2.02e-4);
    }
}

// A square frame, 10 mm wide, around a hole of 2 mm.
TEST(GrainFromMesh, AHoleThatTheRoundingClosesIsRefused) {
    shapes::PolyhedronSize frame;
    for (const double z : {0.0, 0.003})
        for (const double half : {0.005, 0.001})
            for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) frame.corners_m.emplace_back(half * x, half * y, z);
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        frame.faces.insert(frame.faces.end(),
                           {{i, j, j + 8, i + 8}, {j + 4, i + 4, i + 12, j + 12}, {i, i + 4, j + 4, j}, {i + 8, j + 8, j + 12, i + 12}});
    }
    const auto require = [&](double rounding) {
        frame.rounding_m = rounding;
        MeshGrain grain{
            .body = shapes::make_polyhedron(frame), .surface = surface_of(frame, 1.0, {0, 0, 0}), .faces = 32, .volume_m3 = 2.9e-7};
        require_same_holes(grain, "frame.stl");
    };
    EXPECT_NO_THROW(require(8e-4));
    EXPECT_TRUE(has(message_of<UserError>([&] { require(1.1e-3); }),
                    "the surface has 1 hole through it, the grain of 32 faces with a rounding of 0.0011 m has 0"));
}

TEST(GrainFromMesh, WhatCannotBeAGrainIsRefused) {
    const shapes::PolyhedronSize size = test::stone(2, 0.3, 5, 0.0);
    const auto fault = [](const TriangleSurface& surface, const MeshGrainOptions& options) {
        return message_of<UserError>([&] { (void)grain_from_mesh(surface, options, "stone.stl"); });
    };
    TriangleSurface open = surface_of(size, 0.01, {0, 0, 0});
    open.triangles.pop_back();
    EXPECT_TRUE(has(fault(open, {}), "stone.stl"));
    TriangleSurface inverted = surface_of(size, 0.01, {0, 0, 0});
    for (auto& triangle : inverted.triangles) std::swap(triangle[0], triangle[1]);
    EXPECT_NE(fault(inverted, {}), "");
    TriangleSurface two = surface_of(size, 0.01, {0, 0, 0});
    const TriangleSurface other = surface_of(size, 0.01, {0.1, 0, 0});
    const auto first = static_cast<int>(two.points.size());
    two.points.insert(two.points.end(), other.points.begin(), other.points.end());
    for (auto triangle : other.triangles) {
        for (int& i : triangle) i += first;
        two.triangles.push_back(triangle);
    }
    EXPECT_TRUE(has(fault(two, {}), "parts"));
    const TriangleSurface stone = surface_of(size, 0.01, {0, 0, 0});
    EXPECT_TRUE(has(fault(stone, {.faces = 3}), "allowed: 4 to 2000"));
    EXPECT_TRUE(has(fault(stone, {.rounding_m = 0.02}), "rounding"));
    const TriangleSurface coarse = surface_of(test::stone(1, 0.3, 5, 0.0), 0.01, {0, 0, 0});
    EXPECT_TRUE(has(fault(coarse, {.deviation_m = 1e-9}), "a larger deviation_m"));
}

}  // namespace
}  // namespace porepack::converters
