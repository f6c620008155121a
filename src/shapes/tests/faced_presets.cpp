// Presets of grains with faces: sizes, rounding, sphericity, and sizes that are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "shapes/config.hpp"
#include "support/basics.hpp"

namespace porepack::shapes {
namespace {

using core::UserError;
using test::has;
using test::message_of;

constexpr double pi = std::numbers::pi;

Shape shape_of(const std::shared_ptr<const RoundedBody>& body) {
    return {.id = "body", .body = body};
}

TEST(Faced, RoundingKeepsTheVolumeAndSphericityFixesOneRatio) {
    const FacedGrain grain = make_faced({.kind = ShapeKind::cylinder, .diameter_m = 0.01, .height_m = 0.01});
    const ShapeMeasures m = measure(shape_of(grain.body));
    EXPECT_NEAR(m.volume_m3 / (pi * 0.25e-6), 1.0, 1e-12);
    EXPECT_NEAR(grain.body->rounding() / grain.scale, default_rounding * 0.01 * std::cbrt(1.5), 1e-12);
    EXPECT_NEAR(grain.sharp_sphericity, std::cbrt(2.0 / 3.0), 1e-12);
    EXPECT_GT(m.sphericity, grain.sharp_sphericity);
    EXPECT_LT(grain.scale - 1.0, 1e-3);
    for (const ShapeKind kind : {ShapeKind::cylinder, ShapeKind::prism}) {
        const ShapeConfig config{.kind = kind, .sphericity = 0.75, .volume_m3 = 1e-6, .sides = kind == ShapeKind::prism ? 6 : 0};
        const ShapeMeasures solved = measure(make_shape(config));
        EXPECT_NEAR(solved.volume_m3 / 1e-6, 1.0, 1e-9);
        EXPECT_NEAR(solved.sphericity, 0.75, 2e-9);
    }
    // With a rounding that does not fit into longer ones.
    EXPECT_NEAR(
        measure(make_shape({.kind = ShapeKind::cylinder, .sphericity = 0.85, .volume_m3 = 7.33e-7, .rounding_m = 1.5e-3})).sphericity, 0.85,
        2e-9);
}

TEST(Faced, BadSizesAreNamed) {
    const auto fault = [](const ShapeConfig& config) { return message_of<UserError>([&] { (void)make_shape(config); }); };
    using enum ShapeKind;
    EXPECT_TRUE(has(fault({.kind = cylinder, .diameter_m = 1.0}), "a cylinder needs height_m"));
    EXPECT_TRUE(has(fault({.kind = cylinder, .diameter_m = 1.0, .height_m = 1.0, .inner_diameter_m = 0.5}), "no effect on a cylinder"));
    EXPECT_TRUE(has(fault({.kind = ring, .diameter_m = 1.0, .height_m = 1.0, .inner_diameter_m = 1.0}), "hole of the ring is as wide"));
    EXPECT_TRUE(
        has(fault({.kind = ring, .diameter_m = 1.0, .height_m = 1.0, .inner_diameter_m = 0.9, .rounding_m = 0.03}), "half of its wall"));
    EXPECT_TRUE(has(fault({.kind = cube, .side_m = 1.0, .rounding_m = 0.6}), "the rounding of the box is 0.6 m"));
    EXPECT_TRUE(has(fault({.kind = lobed, .diameter_m = 1.0, .height_m = 1.0, .lobe_diameter_m = 0.3}), "do not overlap"));
    EXPECT_TRUE(has(fault({.kind = prism, .diameter_m = 1.0, .height_m = 1.0, .sides = 1000}), "a prism of 1000 sides"));
    EXPECT_TRUE(has(fault({.kind = cylinder, .sphericity = 0.95, .volume_m3 = 1.0}), "no cylinder has sphericity 0.95"));
    EXPECT_TRUE(has(fault({.kind = ring, .sphericity = 0.5, .volume_m3 = 1.0}), "does not determine a ring"));
    EXPECT_TRUE(has(fault({.kind = cylinder, .sphericity = 0.8, .volume_m3 = 1.0, .diameter_m = 1.0}), "may contradict"));
    EXPECT_TRUE(has(fault({.kind = cube, .length_m = 1.0, .side_m = 1.0}), "has no capsules"));
    EXPECT_TRUE(has(fault({.kind = rod, .diameter_m = 1.0, .height_m = 1.0}), "`height_m` has no effect on a rod"));
    EXPECT_TRUE(has(fault({.kind = sphere, .diameter_m = 1.0, .rounding_m = 0.1}), "capsules are round"));
    const auto bad = [](const PolyhedronSize& size) { return message_of<UserError>([&] { (void)make_polyhedron(size); }); };
    PolyhedronSize cube_size = box_size({1, 1, 1}, 0.1);
    std::swap(cube_size.faces[0][0], cube_size.faces[0][1]);
    EXPECT_FALSE(bad(cube_size).empty());
    cube_size = box_size({1, 1, 1}, 0.1);
    cube_size.faces.pop_back();
    EXPECT_TRUE(has(bad(cube_size), "not closed"));
    cube_size = box_size({1, 1, 1}, 0.1);
    cube_size.corners_m[0] = Vec3(0.1, 0.1, 0.1);
    EXPECT_TRUE(has(bad(cube_size), "not flat"));
    cube_size = box_size({1, 1, 1}, 0.1);
    cube_size.corners_m.emplace_back(0.0, 0.0, 0.0);
    EXPECT_TRUE(has(bad(cube_size), "corner 8 of the polyhedron belongs to no face"));
    const PolyhedronSize prism_of_l{.corners_m = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 0, 1}},
                                    .faces = {{5, 4, 3, 2, 1, 0}, {0, 1, 6}, {1, 2, 6}, {2, 3, 6}, {3, 4, 6}, {4, 5, 6}, {5, 0, 6}}};
    EXPECT_TRUE(has(bad(prism_of_l), "face of the polyhedron is not convex"));
    EXPECT_TRUE(has(fault({.kind = lobed, .diameter_m = 1.0, .height_m = 0.1, .lobe_diameter_m = 0.6, .rounding_m = 0.06}),
                    "rounding of a grain with lobes"));
    EXPECT_TRUE(has(fault({.kind = cube, .cavity = Cavity::open, .side_m = 1.0}), "`cavity` has no effect on a cube"));
}

}  // namespace
}  // namespace porepack::shapes
