#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "shapes/config.hpp"
#include "shapes/rounded_body.hpp"
#include "shapes/sphere_clump.hpp"
#include "support/basics.hpp"
#include "support/stones.hpp"

namespace porepack {
using namespace shapes;
namespace {

using test::has;
using test::message_of;

Vec3 random_point(std::mt19937& random, double size = 1.0) {
    std::uniform_real_distribution<double> uniform(-size, size);
    return {uniform(random), uniform(random), uniform(random)};
}

TEST(Capsule, LineIntervalAgreesWithTheDistance) {
    std::mt19937 random(1);
    for (int i = 0; i < 2000; ++i) {
        const Capsule capsule{random_point(random), i % 5 == 0 ? Vec3(Vec3::Zero()) : random_point(random), 0.3};
        const Vec3 origin = random_point(random), direction = i % 7 == 0 ? Vec3(Vec3::UnitZ()) : Vec3(random_point(random).normalized());
        const auto inside = line_interval(capsule, origin, direction);
        for (double t = -3.0; t <= 3.0; t += 0.0517) {
            const bool in = signed_distance(capsule, origin + t * direction) < 0.0;
            EXPECT_EQ(in, inside && t > inside->low && t < inside->high);
        }
        if (inside) {
            EXPECT_NEAR(signed_distance(capsule, origin + inside->low * direction), 0.0, 1e-12);
        }
    }
}

TEST(Capsule, GapIsTheBruteForceMinimum) {
    std::mt19937 random(2);
    for (int i = 0; i < 3000; ++i) {
        Capsule p{random_point(random), random_point(random), 0.0}, q{random_point(random), random_point(random), 0.0};
        if (i % 4 == 1) q.b = q.a + 0.7 * (p.b - p.a);                          // parallel
        if (i % 4 == 2) q.b = q.a;                                              // a point
        if (i % 4 == 3) q.b = q.a + (p.b - p.a) + 1e-9 * random_point(random);  // nearly parallel
        double brute = 1e300;
        for (int k = 0; k <= 400; ++k) {
            const Vec3 at = p.a + (p.b - p.a) * (k / 400.0);
            brute = std::min(brute, (at - closest_on_axis(q, at)).norm());
        }
        EXPECT_LE(gap(p, q), brute + 1e-12);
        EXPECT_GE(gap(p, q), brute - (p.b - p.a).norm() / 400.0);
    }
}

TEST(Shape, OneCapsuleIsExact) {
    const double r = 0.5, L = 1.7;
    const ShapeMeasures m = measure(make_preset(ShapeKind::rod, 2 * r, L));
    EXPECT_NEAR(m.volume_m3, std::numbers::pi * r * r * (L + 4.0 / 3.0 * r), 1e-12);
    EXPECT_NEAR(m.surface_area_m2, 2.0 * std::numbers::pi * r * (L + 2.0 * r), 1e-10);
    // Two half spheres and a cylinder about the long axis.
    const double inertia = std::numbers::pi * r * r * L * r * r / 2.0 + 8.0 / 15.0 * std::numbers::pi * std::pow(r, 5);
    EXPECT_NEAR(m.inertia_per_density_m5(2, 2), inertia, 1e-9);  // the caps by Gauss' rule
}

TEST(Shape, ACapsuleInsideAnotherOrTwiceChangesNothing) {
    Shape rod = make_preset(ShapeKind::rod, 1.0, 2.0);
    const ShapeMeasures alone = measure(rod);
    rod.capsules.push_back(rod.capsules.front());
    rod.capsules.push_back({Vec3::Zero(), Vec3(0, 0, 0.3), 0.2});
    const ShapeMeasures more = measure(rod);
    EXPECT_NEAR(more.volume_m3, alone.volume_m3, 1e-10);
    EXPECT_NEAR(more.surface_area_m2, alone.surface_area_m2, 1e-10);
}

TEST(Shape, BadInputIsNamed) {
    EXPECT_TRUE(
        has(message_of<UserError>([] { (void)dimensions_for(ShapeKind::tetrapod, 1.2, 1e-6, Cavity::filled); }), "0 < sphericity <= 1"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)dimensions_for(ShapeKind::tetrapod, 0.1, 1e-6, Cavity::filled); }),
                    "no tetrapod has sphericity 0.1"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)dimensions_for(ShapeKind::tetrahedron, 0.83, 1e-6, Cavity::filled); }),
                    "jumps where the cavity closes"));
    EXPECT_TRUE(has(message_of<UserError>([] {
                        validate({.id = "x", .capsules = {{Vec3::Zero(), Vec3::Zero(), 0.1}, {Vec3::Ones(), Vec3::Ones(), 0.1}}});
                    }),
                    "not connected"));
    Shape apart{.id = "x", .capsules = {}, .may_be_disconnected = true};
    apart.capsules = {{Vec3::Zero(), Vec3::Zero(), 0.1}, {Vec3::Ones(), Vec3::Ones(), 0.1}};
    EXPECT_NO_THROW(validate(apart));
    EXPECT_NEAR(measure(apart).volume_m3, 2.0 * 4.0 / 3.0 * std::numbers::pi * 1e-3, 1e-12);
    apart.capsules.resize(65, apart.capsules.front());
    EXPECT_TRUE(has(message_of<UserError>([&] { validate(apart); }), "1 to 64"));
    EXPECT_TRUE(has(message_of<UserError>([] {
                        validate({.id = "x", .capsules = {{Vec3::Zero(), Vec3::Zero(), 0.0}}});
                    }),
                    "radius_m from 1e-9"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)make_shape({.kind = ShapeKind::tetrapod}); }), "size is missing"));
    EXPECT_TRUE(has(message_of<UserError>(
                        [] { (void)make_shape({.kind = ShapeKind::tetrapod, .sphericity = 0.5, .volume_m3 = 1e-6, .diameter_m = 1e-3}); }),
                    "contradict"));
}

TEST(Shape, TheTetrahedronsCavityIsFoundBetweenItsLimits) {
    for (const double ratio : {2.80, 2.90, 3.40, 3.46, 3.47, 3.60}) {
        Shape shape = make_preset(ShapeKind::tetrahedron, 2.0, ratio);
        find_cavities(shape);
        const bool closed = ratio > 2.0 * std::sqrt(2.0) && ratio < 2.0 * std::sqrt(3.0);
        EXPECT_EQ(!shape.cavity_points.empty(), closed) << ratio;
    }
}

TEST(Clump, StaysWithinItsTolerance) {
    const Shape shape = make_preset(ShapeKind::tetrapod, 4e-3, 14e-3);
    const double tolerance = 0.05 * 4e-3;
    const auto spheres = sphere_clump(shape, tolerance);
    EXPECT_EQ(spheres.size(), 37U);  // spacing 1.744 mm: 9 pieces per arm, and the middle
    // Every surface point of an arm, seen along its normal, is at most the tolerance above the clump.
    const Capsule& arm = shape.capsules.front();
    const Vec3 axis = (arm.b - arm.a).normalized(), normal = axis.unitOrthogonal();
    for (int k = 0; k <= 1000; ++k) {
        const Vec3 at = arm.a + (arm.b - arm.a) * (k / 1000.0) + arm.radius * normal;
        double reach = 1e300;
        for (const auto& sphere : spheres)
            if (const auto inside = line_interval(sphere, at, normal)) reach = std::min(reach, -inside->high);
        EXPECT_LE(reach, tolerance * (1.0 + 1e-9));
    }
}

TEST(Clump, OfAGrainWithFacesLiesInsideAndWithinItsTolerance) {
    const std::vector<Shape> grains = {{.id = "cube", .body = make_polyhedron(box_size({1.0, 1.0, 1.0}, 0.025))},
                                       {.id = "cylinder", .body = make_ring({.diameter_m = 1.0, .height_m = 1.0, .rounding_m = 0.02})},
                                       {.id = "stone", .body = make_polyhedron(test::stone(1, 0.3, 3, 0.02))}};
    for (const Shape& grain : grains) {
        std::size_t fewer = 0;
        for (const double tolerance : {0.2, 0.1, 0.05}) {
            const double length = tolerance * smallest_diameter(grain);
            const auto spheres = sphere_clump(grain, length);
            EXPECT_GT(spheres.size(), fewer) << grain.id;
            fewer = spheres.size();
            for (const Capsule& sphere : spheres) EXPECT_LT(grain.body->distance(sphere.a) + sphere.radius, 1e-8) << grain.id;
            // Between the points by which the clump was made, the surface may be a little farther away.
            const double error = clump_error(grain, spheres);
            EXPECT_LT(error, 1.3 * length) << grain.id;
            EXPECT_GT(error, 0.5 * length) << grain.id;
        }
        const SphereClump limited = clump_of_at_most(grain, 60);
        EXPECT_GT(limited.spheres.size(), 50U) << grain.id;
        EXPECT_LE(limited.spheres.size(), 60U) << grain.id;
        EXPECT_LT(clump_error(grain, limited.spheres), 1.3 * limited.tolerance_m) << grain.id;
    }
    const Shape& cube = grains.front();
    const auto spheres = sphere_clump(cube, 0.1);
    const double volume = measure(cube).volume_m3;
    EXPECT_LT(measure({.id = "clump", .capsules = spheres}, 1e-4).volume_m3, 0.85 * volume);
    const auto larger = with_volume(spheres, volume);
    EXPECT_NEAR(measure({.id = "clump", .capsules = larger}, 1e-4).volume_m3, volume, 1.2e-3 * volume);
    EXPECT_GT(larger.front().radius, spheres.front().radius);
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)sphere_clump(cube, 0.6); }), "half the grain's thickness"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)clump_of_at_most(cube, 0); }), "no clump of 0 spheres"));
}

}  // namespace
}  // namespace porepack
