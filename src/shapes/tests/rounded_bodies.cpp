// Grains with faces: measures against closed forms; distances, lines and hits against each other and against points of the surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "shapes/config.hpp"
#include "shapes/distance.hpp"
#include "shapes/torus.hpp"
#include "support/basics.hpp"

namespace porepack::shapes {
namespace {

using core::Interval;
using core::UserError;
using test::has;
using test::message_of;

constexpr double pi = std::numbers::pi;

struct Named {
    const char* name;
    std::shared_ptr<const RoundedBody> body;
};

std::vector<Named> bodies() {
    PolyhedronSize wedge{.corners_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                         .faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
                         .rounding_m = 0.05};
    return {{"cylinder", make_ring({.diameter_m = 1.0, .height_m = 1.3, .rounding_m = 0.05})},
            {"sharp cylinder", make_ring({.diameter_m = 1.0, .height_m = 0.7})},
            {"disc", make_ring({.diameter_m = 1.0, .height_m = 0.1, .rounding_m = 0.05})},
            {"sphere", make_ring({.diameter_m = 1.0, .height_m = 1.0, .rounding_m = 0.5})},
            {"ring", make_ring({.diameter_m = 1.0, .inner_diameter_m = 0.7, .height_m = 0.9, .rounding_m = 0.02})},
            {"round ring", make_ring({.diameter_m = 1.0, .inner_diameter_m = 0.6, .height_m = 0.2, .rounding_m = 0.1})},
            {"box", make_polyhedron(box_size({1.0, 0.7, 0.4}, 0.03))},
            {"prism", make_polyhedron(prism_size(5, 1.0, 0.8, 0.02))},
            {"wedge", make_polyhedron(wedge)},
            {"three lobes", make_lobed({3, 1.0, 0.55, 1.2, 0.02})},
            {"four lobes", make_lobed({4, 1.0, 0.48, 0.5, 0.03})}};
}

Vec3 random_point(std::mt19937_64& random, double size = 1.0) {
    std::uniform_real_distribution<double> uniform(-size, size);
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    return {x, y, z};
}

Vec3 random_direction(std::mt19937_64& random) {
    for (;;) {
        const Vec3 x = random_point(random);
        if (const double length = x.norm(); length > 0.1 && length < 1.0) return x / length;
    }
}

Quaternion random_rotation(std::mt19937_64& random) {
    const Vec3 axis = random_direction(random);
    const double angle = std::uniform_real_distribution<double>(0.0, pi)(random);
    return Quaternion(Eigen::AngleAxisd(angle, axis));
}

Shape shape_of(const std::shared_ptr<const RoundedBody>& body) {
    return {.id = "body", .body = body};
}

TEST(RoundedBody, MeasuresAreThoseOfClosedForms) {
    // A cylinder: the core's sides moved out, its ends moved out, and two quarters of a torus (Pappus).
    for (const double r : {0.0, 0.05, 0.2}) {
        const double R = 0.5 - r, h = 0.6 - r;
        const ShapeMeasures m = measure(shape_of(make_ring({.diameter_m = 1.0, .height_m = 1.2, .rounding_m = r})));
        const double volume = 2.0 * pi * h * (R + r) * (R + r) + 2.0 * pi * (R * R * r + 0.5 * pi * R * r * r + 2.0 / 3.0 * r * r * r);
        const double area = 4.0 * pi * h * (R + r) + 2.0 * pi * R * R + 4.0 * pi * (0.5 * pi * R * r + r * r);
        EXPECT_NEAR(m.volume_m3 / volume, 1.0, 1e-12) << r;
        EXPECT_NEAR(m.surface_area_m2 / area, 1.0, 1e-12) << r;
    }
    // A sharp ring.
    const double Ro = 0.5, Ri = 0.3, H = 0.9, ring_volume = pi * (Ro * Ro - Ri * Ri) * H;
    const ShapeMeasures ring = measure(shape_of(make_ring({2.0 * Ro, 2.0 * Ri, H, 0.0})));
    EXPECT_NEAR(ring.volume_m3 / ring_volume, 1.0, 1e-12);
    EXPECT_NEAR(ring.surface_area_m2, 2.0 * pi * (Ro + Ri) * H + 2.0 * pi * (Ro * Ro - Ri * Ri), 1e-12);
    EXPECT_NEAR(ring.inertia_per_density_m5(2, 2) / (0.5 * ring_volume * (Ro * Ro + Ri * Ri)), 1.0, 1e-12);
    EXPECT_NEAR(ring.inertia_per_density_m5(0, 0) / (ring_volume * (3.0 * (Ro * Ro + Ri * Ri) + H * H) / 12.0), 1.0, 1e-12);
    // A ring with a round wall is a torus with a band.
    const double c = 0.4, t = 0.1;
    EXPECT_NEAR(measure(shape_of(make_ring({2.0 * (c + t), 2.0 * (c - t), 2.0 * t, t}))).volume_m3, 2.0 * pi * c * pi * t * t, 1e-12);
    // Steiner's formula for a box with the core a, b, c.
    const Vec3 core = Vec3(1.0, 0.7, 0.4) - Vec3::Constant(0.06);
    const double r = 0.03, edges = 4.0 * core.sum(), faces = 2.0 * (core.x() * core.y() + core.y() * core.z() + core.z() * core.x());
    const ShapeMeasures box = measure(shape_of(make_polyhedron(box_size({1.0, 0.7, 0.4}, r))));
    EXPECT_NEAR(box.volume_m3, core.prod() + faces * r + edges * pi * r * r / 4.0 + 4.0 / 3.0 * pi * r * r * r, 1e-12);
    EXPECT_NEAR(box.surface_area_m2, faces + edges * pi * r / 2.0 + 4.0 * pi * r * r, 1e-12);
    const ShapeMeasures sharp = measure(shape_of(make_polyhedron(box_size({1.0, 0.7, 0.4}, 0.0))));
    EXPECT_NEAR(sharp.inertia_per_density_m5(0, 0), 0.28 * (0.7 * 0.7 + 0.4 * 0.4) / 12.0, 1e-13);
    // All roundings at their largest: a sphere.
    const ShapeMeasures sphere = measure(shape_of(make_ring({.diameter_m = 1.0, .height_m = 1.0, .rounding_m = 0.5})));
    EXPECT_NEAR(sphere.sphericity, 1.0, 1e-12);
    EXPECT_NEAR(sphere.inertia_per_density_m5(1, 1), 0.4 * pi / 6.0 * 0.25, 1e-12);
    // A sharp grain with lobes: sectors of the arcs, and the triangles between them.
    const double radius = 0.275, away = 0.225, beta = pi / 3.0, end = beta + std::asin(away * std::sin(beta) / radius);
    const double section = 3.0 * (radius * radius * end + away * radius * std::sin(end));
    const ShapeMeasures lobes = measure(shape_of(make_lobed({3, 1.0, 0.55, 1.2, 0.0})));
    EXPECT_NEAR(lobes.volume_m3, 1.2 * section, 1e-12);
    EXPECT_NEAR(lobes.surface_area_m2, 2.0 * section + 1.2 * 6.0 * radius * end, 1e-12);
}

// Of the volume by lines through the body: independent of the surface's quadrature.
TEST(RoundedBody, LinesGiveTheVolumeOfTheSurface) {
    std::vector<Interval> parts;
    for (const Named& one : bodies()) {
        const ShapeMeasures m = measure(shape_of(one.body));
        const double volume = m.volume_m3;
        const double reach = one.body->reach_from(m.centre_of_mass_m);
        const Quaternion turned = Quaternion(0.8, 0.3, -0.4, 0.33).normalized();
        constexpr int n = 300;
        double sum = 0.0;
        Vec3 moment = Vec3::Zero();
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const Vec3 origin =
                    m.centre_of_mass_m + turned * Vec3(((i + 0.5) / n * 2.0 - 1.0) * reach, ((j + 0.5) / n * 2.0 - 1.0) * reach, 0.0);
                one.body->line(origin, turned * Vec3::UnitZ(), 0.0, parts);
                for (const Interval& part : parts) {
                    sum += part.high - part.low;
                    moment +=
                        (part.high - part.low) * (origin + 0.5 * (part.low + part.high) * (turned * Vec3::UnitZ()) - m.centre_of_mass_m);
                }
            }
        const double cell = std::pow(2.0 * reach / n, 2);
        EXPECT_NEAR(sum * cell / volume, 1.0, 1e-3) << one.name;
        EXPECT_LT((moment * cell / volume).norm(), 1e-3 * reach) << one.name;
    }
}

TEST(RoundedBody, LinesAgreeWithTheDistance) {
    std::mt19937_64 random(3);
    std::vector<Interval> parts;
    for (const Named& one : bodies())
        for (int i = 0; i < 10000; ++i) {
            const Vec3 origin = random_point(random);
            const Vec3 direction = i % 9 == 0 ? Vec3(Vec3::Unit(i % 3)) : random_direction(random);
            const double grown = i % 4 == 0 ? 0.04 : 0.0;
            one.body->line(origin, direction, grown, parts);
            for (std::size_t p = 0; p < parts.size(); ++p) {
                ASSERT_LT(parts[p].low, parts[p].high) << one.name;
                if (p > 0) ASSERT_GT(parts[p].low, parts[p - 1].high) << one.name;
                for (const double end : {parts[p].low, parts[p].high})
                    ASSERT_NEAR(one.body->distance(origin + end * direction), grown, 1e-8) << one.name << " line " << i;
            }
            for (double t = -2.0; t <= 2.0; t += 0.0817) {
                const double away = one.body->distance(origin + t * direction) - grown;
                if (std::abs(away) < 1e-9) continue;
                const bool inside =
                    std::any_of(parts.begin(), parts.end(), [&](const Interval& part) { return t > part.low && t < part.high; });
                ASSERT_EQ(inside, away < 0.0) << one.name << " line " << i << " at " << t;
            }
        }
}

// No point of the surface is nearer than the distance, and one is nearly as near; the tangent plane is that of the farthest one.
TEST(RoundedBody, DistanceAndSupportAreThoseOfTheSurface) {
    std::mt19937_64 random(4);
    for (const Named& one : bodies()) {
        std::vector<Vec3> surface;
        one.body->for_surface([&](const Vec3& x, const Vec3& n, double) {
            surface.push_back(x);
            EXPECT_NEAR(n.norm(), 1.0, 1e-12);
            EXPECT_NEAR(one.body->distance(x), 0.0, 1e-12) << one.name;
            EXPECT_GT(one.body->distance(x + 1e-4 * n), 0.0) << one.name;
        });
        for (int i = 0; i < 200; ++i) {
            const Vec3 point = random_point(random);
            double nearest = 1e300;
            for (const Vec3& x : surface) nearest = std::min(nearest, (x - point).norm());
            const double distance = one.body->distance(point);
            EXPECT_LE(std::abs(distance), nearest + 1e-12) << one.name;
            if (distance > 0.0) EXPECT_LT(nearest, distance + 0.3) << one.name;
            Vec3 outward;
            EXPECT_EQ(one.body->distance(point, &outward), distance);
            EXPECT_NEAR(outward.norm(), 1.0, 1e-12);
            if (distance > 0.01) EXPECT_NEAR(one.body->distance(point + 1e-5 * outward) - distance, 1e-5, 1e-9) << one.name;
            const Vec3 direction = random_direction(random);
            double farthest = -1e300;
            for (const Vec3& x : surface) farthest = std::max(farthest, x.dot(direction));
            EXPECT_LE(farthest, one.body->support(direction) + 1e-12) << one.name;
            EXPECT_GT(farthest, one.body->support(direction) - 0.1) << one.name;
        }
        for (const double depth : {0.01, 0.04, 0.1})
            if (const auto thinner = one.body->thinned(depth))
                thinner->for_surface(
                    [&](const Vec3& x, const Vec3&, double) { EXPECT_LE(one.body->distance(x), -depth + 1e-12) << one.name; });
        const auto grown = one.body->thinned(-0.02);
        ASSERT_NE(grown, nullptr) << one.name;
        for (int i = 0; i < 2000; ++i)
            if (const Vec3 x = random_point(random); one.body->distance(x) > 0.03)
                EXPECT_NEAR(grown->distance(x), one.body->distance(x) - 0.02, 1e-12) << one.name;
        EXPECT_NEAR(measure(shape_of(one.body->scaled(2.0))).volume_m3 / measure(shape_of(one.body)).volume_m3, 8.0, 1e-11) << one.name;
    }
}

// Rows of points are computed with the instructions of the machine, single points with those that all machines have.
TEST(RoundedBody, RowsOfPointsGiveTheBitsOfSinglePoints) {
    std::mt19937_64 random(5);
    for (const auto& [name, body] : bodies())
        for (int repeat = 0; repeat < 500; ++repeat) {
            PointRow points;
            points.count = 1 + repeat % PointRow::most;
            for (int i = 0; i < PointRow::most; ++i) points.set(i, random_point(random));
            if (repeat == 0) points.set(0, Vec3::Zero());
            DistanceRow found;
            body->distances(points, found);
            for (int i = 0; i < points.count; ++i) {
                Vec3 outward;
                ASSERT_EQ(body->distance(points.at(i), &outward), found.distance[static_cast<std::size_t>(i)]) << name;
                ASSERT_EQ(outward, found.outward.at(i)) << name;
            }
        }
}

TEST(Torus, PartsAreThoseOfTheDistance) {
    std::mt19937_64 random(5);
    std::vector<Interval> parts;
    for (int i = 0; i < 100000; ++i) {
        const double R = i % 10 == 0 ? 0.0 : 0.1 + 0.8 * (i % 7) / 7.0, r = 0.02 + 0.5 * (i % 11) / 11.0;
        const Vec3 origin = random_point(random);
        Vec3 direction = random_direction(random);
        if (i % 13 == 0) direction = Vec3::Unit(i % 3);
        if (i % 17 == 0) direction = (Vec3(0.0, 0.0, 0.3 * random_point(random).x()) - origin).normalized();  // through the axis
        parts.clear();
        add_torus_parts(R, r, origin, direction, parts);
        const auto distance = [&](double t) {
            const Vec3 x = origin + t * direction;
            return std::hypot(x.head<2>().norm() - R, x.z()) - r;
        };
        for (double t = -3.0; t <= 3.0; t += 0.0637) {
            if (std::abs(distance(t)) < 1e-9) continue;
            const bool inside =
                std::any_of(parts.begin(), parts.end(), [&](const Interval& part) { return t > part.low && t < part.high; });
            ASSERT_EQ(inside, distance(t) < 0.0) << "line " << i << " at " << t;
        }
    }
}

// Against points of one surface and the distance from the other grain.
TEST(Touch, TheNearestPlaceIsNotBeatenByPointsOfTheSurface) {
    std::mt19937_64 random(6);
    std::vector<Shape> shapes;
    for (const Named& one : bodies()) shapes.push_back(shape_of(one.body));
    shapes.push_back(make_preset(ShapeKind::tetrapod, 0.3, 0.6));
    for (int i = 0; i < 300; ++i) {
        const Shape &a = shapes[random() % shapes.size()], &b = shapes[random() % shapes.size()];
        const PlacedShape first{a, Vec3::Zero(), random_rotation(random)};
        const PlacedShape second{b, 1.3 * random_direction(random), random_rotation(random)};
        const Nearest place = nearest(first, second, 10.0), back = nearest(second, first, 10.0);
        EXPECT_NEAR(place.gap_m, back.gap_m, 1e-9);
        double brute = 1e300;
        const auto look = [&](const PlacedShape& own, const PlacedShape& other) {
            if (own.shape.body == nullptr) return;
            own.shape.body->for_surface(
                [&](const Vec3& x, const Vec3&, double) { brute = std::min(brute, signed_distance(other, own.to_world(x))); });
        };
        look(first, second);
        look(second, first);
        if (place.gap_m > 0.0) {
            EXPECT_LE(place.gap_m, brute + 1e-9);
            EXPECT_NEAR(signed_distance(first, place.point), 0.5 * place.gap_m, 1e-5);
            EXPECT_NEAR(signed_distance(second, place.point), 0.5 * place.gap_m, 1e-5);
            EXPECT_GT(signed_distance(first, place.point + 1e-3 * place.normal), signed_distance(first, place.point));
        } else {
            EXPECT_LE(place.gap_m, std::max(brute, -0.02)) << a.id << i;
        }
    }
}

TEST(Touch, ReachBeyondATubeIsThatOfTheSurface) {
    std::mt19937_64 random(8);
    for (const Named& one : bodies())
        for (int i = 0; i < 50; ++i) {
            const Shape shape = shape_of(one.body);
            const Quaternion turned = random_rotation(random);
            const PlacedShape grain{shape, 0.6 * random_direction(random), turned};
            const double reach = reach_beyond(grain, [](const Vec3& x) { return 1.0 - x.head<2>().norm(); });
            double farthest = -1e300;
            one.body->for_surface(
                [&](const Vec3& x, const Vec3&, double) { farthest = std::max(farthest, grain.to_world(x).head<2>().norm() - 1.0); });
            EXPECT_GE(reach, farthest - 1e-12) << one.name;
            EXPECT_LT(reach, farthest + 0.06) << one.name;
        }
}

TEST(Touch, TwoBoxesFaceToFaceAndEdgeToEdge) {
    const Shape box = shape_of(make_polyhedron(box_size({1.0, 1.0, 1.0}, 0.05)));
    const Shape rod = make_preset(ShapeKind::rod, 0.2, 1.0);
    const double r2 = std::sqrt(0.5);
    const Quaternion diagonal(std::cos(pi / 8.0), 0.0, 0.0, std::sin(pi / 8.0));  // about z by 45 degrees
    EXPECT_NEAR(nearest({box}, {box, {1.1, 0.2, 0.3}}, 1.0).gap_m, 0.1, 1e-9);
    EXPECT_NEAR(nearest({box}, {box, {0.98, 0.2, 0.3}}, 1.0).gap_m, -0.02, 1e-9);
    // An edge of the core at 0.45 sqrt(2) from the middle, towards a face.
    EXPECT_NEAR(nearest({box}, {box, {1.3, 0.1, 0.3}, diagonal}, 1.0).gap_m, 1.3 - 0.5 - (0.9 * r2 + 0.05), 1e-9);
    EXPECT_NEAR(nearest({box}, {rod, {0.0, 0.0, 0.7}, Quaternion(r2, r2, 0.0, 0.0)}, 1.0).gap_m, 0.1, 1e-9);
    EXPECT_EQ(nearest({box}, {box, {5.0, 0.0, 0.0}}, 0.5).gap_m, 0.5);
    // A rod through the hole of a ring touches nothing.
    const Shape ring = shape_of(make_ring({1.0, 0.6, 0.5, 0.02}));
    EXPECT_NEAR(nearest({ring}, {make_preset(ShapeKind::rod, 0.2, 3.0)}, 1.0).gap_m, 0.2, 1e-9);
    // Beside the axis too; and a rod that reaches into the hole through the wall.
    EXPECT_NEAR(nearest({ring}, {make_preset(ShapeKind::rod, 0.2, 3.0), {0.1, 0.0, 0.0}}, 1.0).gap_m, 0.1, 1e-9);
    EXPECT_LT(nearest({ring}, {make_preset(ShapeKind::rod, 0.2, 1.0), {0.62, 0.0, 0.0}, Quaternion(r2, 0.0, r2, 0.0)}, 1.0).gap_m, -0.1);
    // Two rings whose walls lie in each other as a whole.
    EXPECT_LT(nearest({ring}, {ring, {0.78, 0.0, 0.0}, Quaternion(r2, r2, 0.0, 0.0)}, 1.0).gap_m, -0.1);
}

TEST(RoundedBody, FacetsAreAClosedSurfaceNearTheExactOne) {
    using Corner = std::array<double, 3>;
    const auto key = [](const Vec3& x) { return Corner{x.x() + 0.0, x.y() + 0.0, x.z() + 0.0}; };
    for (const Named& one : bodies())
        for (const double deviation : {0.02, 0.005}) {
            const std::vector<Facet> facets = one.body->facets(deviation, 0.3);
            std::map<std::pair<Corner, Corner>, int> sides;
            double volume = 0.0, worst = 0.0;
            for (const Facet& facet : facets) {
                volume += facet[0].dot(facet[1].cross(facet[2])) / 6.0;
                worst = std::max(worst, std::abs(one.body->distance((facet[0] + facet[1] + facet[2]) / 3.0)));
                for (std::size_t c = 0; c < 3; ++c) {
                    worst = std::max(worst, std::abs(one.body->distance(facet[c])));
                    ++sides[{key(facet[c]), key(facet[(c + 1) % 3])}];
                }
            }
            for (const auto& [side, count] : sides) {
                const auto other = sides.find({side.second, side.first});
                ASSERT_TRUE(count == 1 && other != sides.end()) << one.name;
            }
            const double exact = measure(shape_of(one.body)).volume_m3;
            std::printf("  %-14s %.3f: %5zu facets, deviation %.4f, volume %+.2e\n", one.name, deviation, facets.size(), worst,
                        volume / exact - 1.0);
            EXPECT_LE(worst, deviation) << one.name;
            EXPECT_NEAR(volume / exact, 1.0, 0.5 * deviation) << one.name;
        }
}

// A cone of 64 sides whose corners lie at its base, and a tip far away.
TEST(RoundedBody, APolyhedronsThicknessIsThatOfItsLargestBall) {
    PolyhedronSize cone;
    std::vector<int> base;
    for (int i = 0; i < 64; ++i) {
        cone.corners_m.emplace_back(std::cos(2.0 * pi * i / 64), std::sin(2.0 * pi * i / 64), 0.0);
        base.insert(base.begin(), i);
        cone.faces.push_back({i, (i + 1) % 64, 64});
    }
    cone.corners_m.emplace_back(0.0, 0.0, 2.0);
    cone.faces.push_back(base);
    const auto body = make_polyhedron(cone);
    const double rho = std::cos(pi / 64.0);  // of the inscribed circle; the ball of a cone with this base
    EXPECT_NEAR(body->thickness(), 2.0 * 2.0 * rho / (rho + std::hypot(rho, 2.0)), 1e-4);
    // A sharp tip: its part of a sphere is nearly a half one.
    cone.corners_m.back().z() = 30.0;
    cone.rounding_m = 0.2;
    double around_tip = 0.0;
    make_polyhedron(cone)->for_surface([&](const Vec3& x, const Vec3&, double area) {
        if (std::abs((x - Vec3(0, 0, 30)).norm() - 0.2) < 1e-9 && x.z() > 30.0 - 0.2) around_tip += area;
    });
    const double half_angle = std::atan(1.0 / 30.0);  // of a round cone
    EXPECT_NEAR(around_tip / (0.04 * 2.0 * pi * (1.0 - std::sin(half_angle))), 1.0, 2e-3);
}

TEST(RoundedBody, IsReadAsItIsWritten) {
    for (const Named& one : bodies()) {
        const auto again = body_from_json(one.body->to_json(), "here");
        EXPECT_NEAR(measure(shape_of(again)).volume_m3 / measure(shape_of(one.body)).volume_m3, 1.0, 1e-14) << one.name;
    }
    const auto fault = [](const char* json) {
        return message_of<UserError>([&] { (void)body_from_json(core::Json::parse(json), "here"); });
    };
    EXPECT_TRUE(has(fault(R"({"diameter_m":1})"), "`kind` is missing"));
    EXPECT_TRUE(has(fault(R"({"kind":"cone"})"), "unknown kind of body: cone"));
    EXPECT_TRUE(has(fault(R"({"kind":"cylinder","diameter_m":1,"height_m":1})"), "`rounding_m` is missing"));
    EXPECT_TRUE(has(fault(R"({"kind":"cylinder","diameter_m":1,"height_m":1,"rounding_m":0,"sides":3})"), "unknown key `sides`"));
    EXPECT_TRUE(has(fault(R"({"kind":"cylinder","diameter_m":1,"height_m":1,"rounding_m":"a"})"), "not a finite number"));
    EXPECT_TRUE(has(fault(R"({"kind":"ring","diameter_m":1,"inner_diameter_m":0,"height_m":1,"rounding_m":0})"), "a ring needs a hole"));
    EXPECT_TRUE(has(fault(R"({"kind":"polyhedron","corners_m":[[0,0]],"faces":[[0,1,2]],"rounding_m":0})"), "points of three numbers"));
}

}  // namespace
}  // namespace porepack::shapes
