// Vessels that are given by the surface of their inner space, against the same vessels known exactly.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "lbm/permeability.hpp"
#include "packing/grains.hpp"
#include "packing/porosity.hpp"
#include "pouring/dem/capsule_dem.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "support/basics.hpp"
#include "support/helpers.hpp"
#include "support/vessel_meshes.hpp"
#include "vessels/config.hpp"
#include "vessels/mesh.hpp"

namespace porepack::test {
namespace {

using geometry::TriangleMesh;

Container vessel_of(TriangleMesh mesh) {
    return Container(std::make_shared<const vessels::MeshVessel>(std::move(mesh)));
}

std::vector<double> evenly(double to, int count) {
    std::vector<double> heights;
    for (int i = 0; i <= count; ++i) heights.push_back(to * i / count);
    return heights;
}

TriangleMesh cylinder_mesh(int facets, double radius, double height) {
    return tube_mesh(facets, {0.0, height}, [&](double) { return radius; });
}

// Facets lie on both sides of the circle of their area: by r turn^2 / 12 at the corners, half of that in their middles.
TEST(MeshVessels, AnswerAsExactOnes) {
    constexpr int facets = 256;
    const double turn = 2.0 * std::numbers::pi / facets, off = 0.05 * turn * turn / 11.0;
    for (const bool core : {false, true}) {
        const Container exact = vessels::parse_container(core ? "annulus:0.04,0.1,0.2" : "cylinder:0.1,0.2");
        const Container mesh = vessel_of(core ? annulus_mesh(facets, 0.02, 0.05, 0.2) : cylinder_mesh(facets, 0.05, 0.2));
        EXPECT_NEAR(mesh.inner_area_m2() / exact.inner_area_m2(), 1.0, 1e-12);
        EXPECT_NEAR(mesh.vessel().mean_area({0.05, 0.06}) / exact.inner_area_m2(), 1.0, 1e-9);
        EXPECT_NEAR(mesh.vessel().side_per_volume() / exact.vessel().side_per_volume(), 1.0, turn * turn / 6.0);
        EXPECT_NEAR((mesh.low() - exact.low()).norm() + (mesh.high() - exact.high()).norm(), 0.0, 4.0 * off);
        std::vector<Interval> parts;
        for (int i = 0; i < 400; ++i) {
            // Also below the floor and above the opening, where the sides go on.
            const Vec3 x(0.06 * std::sin(1.7 * i), 0.06 * std::cos(2.9 * i), 0.1 + 0.5 * std::sin(0.3 * i));
            if (x.head<2>().norm() > 1e-3) EXPECT_NEAR(mesh.wall_distance(x), exact.wall_distance(x), off) << i;
            if (std::abs(exact.wall_distance(x)) < off) continue;
            mesh.vessel().column(x.x(), x.y(), parts);
            EXPECT_EQ(geometry::contains(parts, x.z()), exact.wall_distance(x) > 0.0) << i;
            if (exact.wall_distance(x) < 0.0) continue;
            const Vec3 y(0.04 * std::cos(0.9 * i), 0.04 * std::sin(1.3 * i), 0.1 * std::cos(i));
            EXPECT_NEAR(std::max(0.0, mesh.vessel().least_distance(x, y)), std::max(0.0, exact.vessel().least_distance(x, y)), 1.5 * off)
                << i;
            const auto hit = mesh.vessel().first_hit(x, y - x), known = exact.vessel().first_hit(x, y - x);
            // Only a segment that grazes a wall may meet it in one of the vessels.
            if (hit.has_value() != known.has_value())
                EXPECT_LT(std::min(exact.vessel().least_distance(x, y), mesh.vessel().least_distance(x, y)), off) << i;
            if (!hit || !known) continue;
            EXPECT_NEAR(exact.wall_distance(x + *hit * (y - x)), 0.0, off) << i;
        }
    }
}

TEST(MeshVessels, VolumeOfAFrustumAndOfABend) {
    for (const int facets : {16, 64, 256}) {
        const Container cone = vessel_of(tube_mesh(facets, {0.0, 0.3}, [](double z) { return 0.1 - z / 6.0; }));
        EXPECT_NEAR(cone.inner_area_m2() / (std::numbers::pi * (0.01 + 0.005 + 0.0025) / 3.0), 1.0,
                    1e-12);  // sections have the circle's area
        EXPECT_NEAR(cone.vessel().mean_area({0.1, 0.2}) / vessels::parse_container("cone:0.2,0.1,0.3").vessel().mean_area({0.1, 0.2}), 1.0,
                    1e-12);
    }
    const Container bend = vessel_of(tube_mesh(
        48, evenly(0.2, 40), [](double) { return 0.02; },
        [](double z) { return Vec3(0.015 * (1.0 - std::cos(std::numbers::pi * z / 0.2)), 0.0, z); }));
    EXPECT_NEAR(bend.vessel().mean_area({0.03, 0.17}) / (std::numbers::pi * 4e-4), 1.0, 1e-9);
    // Horizontal sections are circles; a wall inclined by 13 degrees at most is nearer than they are wide.
    EXPECT_NEAR(bend.wall_distance({0.015, 0.0, 0.1}) / 0.02, std::cos(std::atan(0.015 * std::numbers::pi / 0.2)), 0.01);
    EXPECT_LT(bend.wall_distance({0.0, 0.0, 0.2}), 0.0);
    EXPECT_GT(bend.wall_distance({0.03, 0.0, 0.35}), 0.019);
}

Packing poured(const Shape& shape, const Container& container, pouring::Fill fill, long grains) {
    const Folder folder;
    Packing packing = pouring::dem::pour_with_capsules({{.shape = shape, .number_fraction = 1.0}}, container,
                                                       {.fill = fill, .grains = grains}, folder.path())
                          .packing;
    EXPECT_EQ(packing.bodies.size(), static_cast<std::size_t>(grains));
    EXPECT_LT(packing::find_overlaps(packing).largest_with_wall_m, 0.02 * packing::finest_diameter(packing));
    return packing;
}

double porosity_below(const Packing& packing, double top) {
    return packing::porosity(packing::Grains(packing), packing.container, {0.0, top}, 20000).value;
}

// The facets lie up to 2.5e-5 of the radius beside the tube.
TEST(MeshVessels, TheSamePosesInATubeOfFacets) {
    Packing packing = poured(make_preset(ShapeKind::sphere, 0.006, 0.0), make_cylinder(0.03, 0.12), pouring::Fill::lattice, 60);
    const double height = 0.025;
    std::vector<double> porosity, k;
    for (const bool facets : {false, true}) {
        if (facets) packing.container = vessel_of(cylinder_mesh(256, 0.015, 0.12));
        porosity.push_back(porosity_below(packing, height));
        const auto solid = std::make_shared<const packing::Grains>(packing);
        const PoreSpace pores = pore_space_of(solid, packing.container, {0.005, 0.02}, 0.006);
        k.push_back(lbm::lbm_permeability(pores, 1e-3, {.iteration_tolerance = 1e-4, .grids = 1}).fine().permeability_m2);
    }
    std::printf("  porosity %+.1e, k %+.1e\n", porosity[1] - porosity[0], k[1] / k[0] - 1.0);
    EXPECT_NEAR(porosity[1], porosity[0], 1e-3);
    EXPECT_NEAR(k[1] / k[0], 1.0, 5e-3);
}

// No grain is lost, none lies beyond a wall; a bed of spheres is about as dense as between exact walls.
TEST(MeshVessels, PoursAsBetweenExactWalls) {
    const Shape sphere = make_preset(ShapeKind::sphere, 0.005, 0.0), tetrapod = make_preset(ShapeKind::tetrapod, 0.003, 0.004),
                pellet = make_shape({.kind = ShapeKind::cylinder, .diameter_m = 0.006, .height_m = 0.006});
    const Container facets = vessel_of(annulus_mesh(64, 0.008, 0.025, 0.1));
    const double known =
                     porosity_below(poured(sphere, vessels::parse_container("annulus:0.016,0.05,0.1"), pouring::Fill::lattice, 120), 0.01),
                 found = porosity_below(poured(sphere, facets, pouring::Fill::lattice, 120), 0.01);
    std::printf("  porosity %.3f between exact walls, %.3f between facets\n", known, found);
    EXPECT_NEAR(found, known, 0.03);  // two beds of 120 grains: their poses differ
    (void)poured(tetrapod, facets, pouring::Fill::lattice, 8);
    (void)poured(pellet, vessel_of(tube_mesh(16, {0.0, 0.06}, [](double z) { return 0.01 + 0.25 * z; })), pouring::Fill::lattice, 4);
}

// A cube on the ridge of an insert: the ridge presses into a face, whose corners and edges it does not meet.
TEST(MeshVessels, ARidgeCarriesACube) {
    // A box of 60 x 60 x 60 mm with a ridge along y, 20 mm high; seen along y: 0, left foot, ridge, right foot.
    const std::vector<std::array<double, 2>> outline = {{0.0, 0.0},  {0.02, 0.0},  {0.03, 0.02}, {0.04, 0.0},
                                                        {0.06, 0.0}, {0.06, 0.06}, {0.0, 0.06}};
    TriangleMesh mesh;
    const int n = static_cast<int>(outline.size());
    for (const double y : {0.0, 0.06})
        for (const auto& [x, z] : outline) mesh.points_m.emplace_back(x, y, z);
    for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        mesh.triangles.push_back({i, j + n, j});
        mesh.triangles.push_back({i, i + n, j + n});
    }
    for (const auto& [a, b, c] : {std::array{0, 1, 6}, {1, 2, 6}, {2, 5, 6}, {2, 3, 5}, {3, 4, 5}}) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a + n, c + n, b + n});
    }
    const Container vessel = vessel_of(mesh);
    const Shape cube = make_shape({.kind = ShapeKind::box, .rounding_m = 0.0006, .size_m = {0.012, 0.012, 0.012}});
    const double stiffness = 1000.0, mass = 1000.0 * 1.728e-6;
    pouring::dem::CapsuleDem dem(vessel, {cube}, 1000.0, {.normal_stiffness_N_per_m = stiffness, .tangential_stiffness_N_per_m = stiffness},
                                 {.time_step_s = 2e-5, .gravity_m_per_s2 = {0.0, 0.0, -9.81}});
    dem.add(0, {0.03, 0.03, 0.0262}, Quaternion::Identity(), Vec3::Zero(), Vec3::Zero());
    dem.step(20000);
    const double sunk = 0.026 - dem.packing().bodies.front().position_m.z(), weight = mass * 9.81;
    std::printf("  sunk by %.3g m: %.3g N of %.3g N\n", sunk, 0.5 * stiffness * sunk, weight);
    EXPECT_GT(sunk, 0.0);
    EXPECT_LT(sunk, 2.0 * weight / stiffness);  // not deeper than a single contact
    EXPECT_NEAR(dem.wall_loads().sides_N / -weight, 1.0, 0.02);
}

TEST(MeshVessels, SayWhatIsWrongWithThem) {
    const auto fault = [](TriangleMesh mesh) { return message_of<UserError>([&] { (void)vessel_of(std::move(mesh)); }); };
    const TriangleMesh good = cylinder_mesh(12, 0.05, 0.2);
    TriangleMesh mesh = good;
    mesh.triangles.erase(mesh.triangles.begin() + 3);
    EXPECT_TRUE(has(fault(mesh), "is open at the side from"));
    mesh = good;
    for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
    EXPECT_TRUE(has(fault(mesh), "point inward"));
    mesh = good;
    mesh.points_m[12].z() += 0.01;  // the opening has a tip
    EXPECT_TRUE(has(fault(mesh), "no opening"));
    mesh = good;
    for (Vec3& point : mesh.points_m) point.z() += 0.01;
    EXPECT_TRUE(has(fault(mesh), "begins at z = 0.01 m"));
    mesh = good;
    for (const Vec3& point : good.points_m) mesh.points_m.push_back(point + Vec3(0.2, 0.0, 0.0));
    for (const auto& [a, b, c] : good.triangles) mesh.triangles.push_back({a + 24, b + 24, c + 24});
    EXPECT_TRUE(has(fault(mesh), "encloses 2 separate spaces"));
    mesh = good;
    mesh.triangles[2] = mesh.triangles[1];
    EXPECT_TRUE(has(fault(mesh), "two triangles have the side"));
}

}  // namespace
}  // namespace porepack::test
