// Rounded polyhedra that are not convex: measures against closed forms; distances, lines and points of the surface against each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "shapes/rounded_mesh.hpp"
#include "shapes/shape.hpp"
#include "support/basics.hpp"
#include "support/stones.hpp"

namespace porepack::shapes {
namespace {

using core::Interval;
using core::UserError;
using test::has;
using test::message_of;

constexpr double pi = std::numbers::pi;

Shape shape_of(const std::shared_ptr<const RoundedBody>& body) {
    return {.id = "body", .body = body};
}

// A prism on a polygon, turned so that nothing is parallel to an axis.
PolyhedronSize prism_on(const std::vector<std::array<double, 2>>& polygon, const std::vector<std::vector<int>>& ends, double height,
                        double rounding) {
    PolyhedronSize size{.corners_m = {}, .faces = {}, .rounding_m = rounding};
    const Quaternion turned = Quaternion(0.8, 0.3, -0.4, 0.33).normalized();
    const auto n = static_cast<int>(polygon.size());
    for (const double z : {-0.5 * height, 0.5 * height})
        for (const auto& [x, y] : polygon) size.corners_m.push_back(turned * Vec3(x, y, z));
    for (const auto& end : ends) {
        std::vector<int> up = end;
        for (int& i : up) i += n;
        size.faces.push_back(up);
        size.faces.emplace_back(end.rbegin(), end.rend());
    }
    for (int i = 0; i < n; ++i) size.faces.push_back({i, (i + 1) % n, (i + 1) % n + n, i + n});
    return size;
}

// Six corners, one of them with a solid angle of 270 degrees.
PolyhedronSize angle_piece(double height, double rounding) {
    return prism_on({{0, 0}, {1, 0}, {1, 0.4}, {0.4, 0.4}, {0.4, 1}, {0, 1}}, {{0, 1, 2, 3}, {0, 3, 4, 5}}, height, rounding);
}

// A square frame.
PolyhedronSize frame(double rounding) {
    PolyhedronSize size{.corners_m = {}, .faces = {}, .rounding_m = rounding};
    for (const double z : {0.0, 0.3})
        for (const double half : {0.5, 0.25})
            for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) size.corners_m.emplace_back(half * x, half * y, z);
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        size.faces.push_back({i, j, j + 8, i + 8});
        size.faces.push_back({j + 4, i + 4, i + 12, j + 12});
        size.faces.push_back({i, i + 4, j + 4, j});
        size.faces.push_back({i + 8, j + 8, j + 12, i + 12});
    }
    return size;
}

struct Named {
    const char* name;
    std::shared_ptr<const RoundedBody> body;
};
std::vector<Named> bodies() {
    return {{"angle piece", make_polyhedron(angle_piece(0.5, 0.05))},
            {"frame", make_polyhedron(frame(0.03))},
            {"stone", make_polyhedron(test::stone(2, 0.3, 5, 0.02))},
            {"pitted stone", make_polyhedron(test::stone(1, 0.6, 11, 0.02))},
            {"sharp stone", make_polyhedron(test::stone(1, 0.4, 3, 0.0))}};
}

Vec3 random_point(std::mt19937_64& random, double size = 1.0) {
    std::uniform_real_distribution<double> uniform(-size, size);
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    return {x, y, z};
}

// Strips of the sides, which overlap in a square at the inner corner, five quarters of a circle; the same above and below, rounded.
TEST(RoundedMesh, MeasuresAreThoseOfClosedForms) {
    for (const double r : {0.0, 0.02, 0.05}) {
        const double h = 0.5, area = 0.64, perimeter = 4.0, corners = 1.25 * pi - 1.0;
        const ShapeMeasures m = measure(shape_of(make_polyhedron(angle_piece(h, r))));
        const double volume = h * (area + perimeter * r + corners * r * r) +
                              2.0 * (area * r + perimeter * pi * r * r / 4.0 + corners * 2.0 / 3.0 * r * r * r);
        EXPECT_NEAR(m.volume_m3 / volume, 1.0, 1e-6) << r;
        // The derivative by r.
        const double surface = h * (perimeter + 2.0 * corners * r) + 2.0 * (area + perimeter * pi * r / 2.0 + corners * 2.0 * r * r);
        EXPECT_NEAR(m.surface_area_m2 / surface, 1.0, 1e-6) << r;
    }
    const ShapeMeasures sharp = measure(shape_of(make_polyhedron(frame(0.0))));
    EXPECT_NEAR(sharp.volume_m3, 0.75 * 0.3, 1e-12);
    EXPECT_NEAR(sharp.inertia_per_density_m5(2, 2), 0.3 * (1.0 - 0.0625) / 6.0, 1e-12);
    EXPECT_NEAR(make_polyhedron(frame(0.03))->thickness(), 0.31, 0.04);
    EXPECT_NEAR(make_polyhedron(angle_piece(0.5, 0.05))->thickness(), 0.55, 0.04);
}

TEST(RoundedMesh, LinesGiveTheVolumeOfTheSurface) {
    std::vector<Interval> parts;
    for (const Named& one : bodies()) {
        const ShapeMeasures m = measure(shape_of(one.body));
        const double reach = one.body->reach_from(m.centre_of_mass_m);
        const Quaternion turned = Quaternion(0.5, -0.3, 0.7, 0.2).normalized();
        constexpr int n = 200;
        double sum = 0.0;
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const Vec3 across(((i + 0.5) / n * 2.0 - 1.0) * reach, ((j + 0.5) / n * 2.0 - 1.0) * reach, 0.0);
                one.body->line(m.centre_of_mass_m + turned * across, turned * Vec3::UnitZ(), 0.0, parts);
                for (const Interval& part : parts) sum += part.high - part.low;
            }
        EXPECT_NEAR(sum * std::pow(2.0 * reach / n, 2) / m.volume_m3, 1.0, 1e-3) << one.name;
    }
}

TEST(RoundedMesh, LinesAgreeWithTheDistance) {
    std::mt19937_64 random(3);
    std::vector<Interval> parts;
    for (const Named& one : bodies())
        for (int i = 0; i < 3000; ++i) {
            const Vec3 origin = random_point(random);
            const Vec3 direction = i % 9 == 0 ? Vec3(Vec3::Unit(i % 3)) : random_point(random).normalized();
            const double grown = i % 4 == 0 ? 0.04 : 0.0;
            one.body->line(origin, direction, grown, parts);
            for (std::size_t p = 0; p < parts.size(); ++p) {
                ASSERT_LT(parts[p].low, parts[p].high) << one.name;
                if (p > 0) ASSERT_GT(parts[p].low, parts[p - 1].high) << one.name;
                for (const double end : {parts[p].low, parts[p].high})
                    ASSERT_NEAR(one.body->distance(origin + end * direction), grown, 1e-7) << one.name << " line " << i;
            }
            for (double t = -2.0; t <= 2.0; t += 0.0817) {
                const double away = one.body->distance(origin + t * direction) - grown;
                if (std::abs(away) < 1e-7) continue;
                const bool inside =
                    std::any_of(parts.begin(), parts.end(), [&](const Interval& part) { return t > part.low && t < part.high; });
                ASSERT_EQ(inside, away < 0.0) << one.name << " line " << i << " at " << t;
            }
        }
}

// The core's triangles, each searched by itself, and the solid angle that they fill for the sign.
TEST(RoundedMesh, DistanceIsThatOfTheNearestTriangle) {
    std::mt19937_64 random(4);
    for (const Named& one : bodies()) {
        const core::Json json = one.body->to_json();
        const double r = one.body->rounding();
        std::vector<std::array<Vec3, 3>> triangles;
        for (const auto& face : json.at("faces")) {
            std::array<Vec3, 3> x;
            for (std::size_t i = 0; i < 3; ++i)
                for (int axis = 0; axis < 3; ++axis)
                    x[i][axis] = json.at("corners_m").at(face.at(i).get<std::size_t>()).at(static_cast<std::size_t>(axis));
            triangles.push_back(x);
        }
        for (int i = 0; i < 2000; ++i) {
            const Vec3 point = random_point(random, i % 2 == 0 ? 0.6 : 2.0);
            double nearest = 1e300, solid_angle = 0.0;
            for (const auto& [a, b, c] : triangles) {
                const Capsule sides[] = {{a, b, 0.0}, {b, c, 0.0}, {c, a, 0.0}};
                for (const Capsule& side : sides) nearest = std::min(nearest, (point - closest_on_axis(side, point)).norm());
                const Vec3 normal = (b - a).cross(c - a).normalized(), foot = point - normal.dot(point - a) * normal;
                if ((b - a).cross(foot - a).dot(normal) > 0 && (c - b).cross(foot - b).dot(normal) > 0 &&
                    (a - c).cross(foot - c).dot(normal) > 0)
                    nearest = std::min(nearest, std::abs(normal.dot(point - a)));
                const Vec3 pa = a - point, pb = b - point, pc = c - point;
                solid_angle += 2.0 * std::atan2(pa.dot(pb.cross(pc)), pa.norm() * pb.norm() * pc.norm() + pa.dot(pb) * pc.norm() +
                                                                          pb.dot(pc) * pa.norm() + pc.dot(pa) * pb.norm());
            }
            Vec3 outward;
            const double distance = one.body->distance(point, &outward);
            ASSERT_NEAR(distance, (solid_angle > 2.0 * pi ? -nearest : nearest) - r, 1e-12) << one.name << " " << i;
            ASSERT_NEAR(outward.norm(), 1.0, 1e-12);
            ASSERT_NEAR(one.body->distance(point + 1e-6 * outward) - distance, 1e-6, 2e-7) << one.name << " " << i;
        }
    }
}

TEST(RoundedMesh, PointsOfTheSurfaceLieOnIt) {
    for (const Named& one : bodies()) {
        double worst = 0.0;
        one.body->for_surface([&](const Vec3& x, const Vec3& n, double) {
            EXPECT_NEAR(n.norm(), 1.0, 1e-12);
            worst = std::max(worst, std::abs(one.body->distance(x)));
        });
        EXPECT_LT(worst, 1e-4) << one.name;
        const double volume = surface_measures(*one.body).volume_m3;
        EXPECT_NEAR(surface_measures(*one.body->scaled(2.0)).volume_m3 / volume, 8.0, 1e-9) << one.name;
        EXPECT_GT(one.body->hull().volume_m3, volume) << one.name;
        const auto again = body_from_json(one.body->to_json(), "here");
        EXPECT_EQ(again->to_json(), one.body->to_json()) << one.name;
    }
}

TEST(RoundedMesh, BadSurfacesAreNamed) {
    PolyhedronSize open = angle_piece(0.5, 0.0);
    open.faces.pop_back();
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)make_polyhedron(open); }), "not closed"));
    PolyhedronSize crossing = angle_piece(0.5, 0.0);
    for (std::size_t i : {4u, 10u}) crossing.corners_m[i] += 1.2 * (crossing.corners_m[2] - crossing.corners_m[5]);
    EXPECT_NE(message_of<UserError>([&] { (void)make_polyhedron(crossing); }), "");
    PolyhedronSize inverted = angle_piece(0.5, 0.0);
    for (auto& face : inverted.faces) std::reverse(face.begin(), face.end());
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)make_polyhedron(inverted); }), "inward"));
    PolyhedronSize two = angle_piece(0.5, 0.0);
    const PolyhedronSize other = angle_piece(0.5, 0.0);
    const auto first = static_cast<int>(two.corners_m.size());
    for (const Vec3& corner : other.corners_m) two.corners_m.push_back(corner + Vec3(3, 0, 0));
    for (auto face : other.faces) {
        for (int& i : face) i += first;
        two.faces.push_back(face);
    }
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)make_polyhedron(two); }), "several parts"));
}

}  // namespace
}  // namespace porepack::shapes
