// Annuli and cones: the engines' walls against rigid bodies, flow through an annular duct, pours.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "lbm/permeability.hpp"
#include "packing/grains.hpp"
#include "packing/porosity.hpp"
#include "pouring/dem/capsule_dem.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "shapes/config.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack::test {
namespace {

constexpr double pi = std::numbers::pi, g = 9.81;

Shape rod(double diameter, double length) {
    return {.id = "rod", .capsules = {{Vec3(-0.5 * length, 0.0, 0.0), Vec3(0.5 * length, 0.0, 0.0), 0.5 * diameter}}};
}

// A ball rolls down a straight line of the cone with 5/7 of what would slide.
TEST(RoundWalls, ABallRollsDownACone) {
    const double degrees = 8.0, seconds = 0.3, radius = 0.005, slope = 1.0 / std::tan(degrees * pi / 180.0);
    const Container cone = parse_container(fmt::format("cone:0.02,{:.12g},0.06", 0.02 + 2.0 * slope * 0.06));
    const ContactLaw law{.friction = 0.8, .wall_friction = 0.8};
    CapsuleDem dem(cone, {rod(2.0 * radius, 0.0)}, 1000.0, law, {.time_step_s = 2e-6, .sleep = false});
    const double z = 0.05, pressed = 4.0 / 3.0 * pi * std::pow(radius, 3) * 1000.0 * g * std::cos(degrees * pi / 180.0) / 2.5e3;
    // At the distance at which the wall carries its weight.
    const double away = 0.01 + slope * z - (radius - pressed) * std::hypot(1.0, slope);
    dem.add(0, Vec3(0.0, away, z), Quaternion::Identity());
    dem.step(std::lround(seconds / 2e-6));
    const Vec3 moved = dem.pose(0).position_m - Vec3(0.0, away, z);
    const double expected = 0.5 * 5.0 / 7.0 * g * std::sin(degrees * pi / 180.0) * seconds * seconds;
    std::printf("  %.6f of %.6f m\n", moved.norm(), expected);
    EXPECT_NEAR(moved.norm() / expected, 1.0, 5e-3);
    EXPECT_NEAR(moved.x(), 0.0, 1e-12);
    EXPECT_NEAR(moved.z() / moved.y(), 1.0 / slope, 1e-3);  // along the wall
}

// A rod, and a cylinder with faces, that fly against the inner wall with their sides. Without friction and damping they keep their energy;
// a hit in the middle turns them back.
TEST(RoundWalls, SidesBounceOffAnInnerWall) {
    const Container annulus = parse_container("annulus:0.02,0.2,0.2");
    const ContactLaw law{.normal_damping = 0.0, .tangential_damping = 0.0, .friction = 0.0, .wall_friction = 0.0};
    const Shape pellet = make_shape({.kind = ShapeKind::cylinder, .diameter_m = 0.006, .height_m = 0.02});
    const Quaternion along_y(Eigen::AngleAxisd(pi / 2.0, Vec3::UnitZ())), lying(Eigen::AngleAxisd(pi / 2.0, Vec3::UnitX()));
    for (const bool faces : {false, true})
        for (const double beside : {0.0, 0.006}) {
            CapsuleDem dem(annulus, {faces ? pellet : rod(0.006, 0.014)}, 1000.0, law,
                           {.time_step_s = 1e-6, .gravity_m_per_s2 = Vec3::Zero(), .sleep = false});
            dem.add(0, Vec3(0.016, beside, 0.1), faces ? lying : along_y, Vec3(-0.5, 0.0, 0.0));
            const double before = dem.energy().total();
            dem.step(beside == 0.0 ? 20000 : 9000);  // beside the middle, before its other half hits
            const double after = dem.energy().total();
            const Vec3 place = dem.pose(0).position_m;
            std::printf("  faces %d, beside %g m: energy changed by %.1e, at %.5f m\n", faces, beside, after / before - 1.0, place.x());
            EXPECT_NEAR(after / before, 1.0, faces ? 1e-3 : 1e-5);
            EXPECT_EQ(dem.energy().elastic_J, 0.0);
            if (beside == 0.0) {
                EXPECT_GT(place.x(), 0.018);
                EXPECT_NEAR(dem.energy().rotational_J / after, 0.0, 1e-6);
            } else {
                EXPECT_GT(dem.energy().rotational_J / after, 0.5);
            }
        }
}

// Four arms that meet in the middle touch an inner wall there as one ball does.
TEST(RoundWalls, ArmsThatMeetShareTheWall) {
    const double overlap = 1e-5, one = 0.5 * 5e3 * overlap * overlap;
    Shape cross{.id = "cross", .capsules = {}};
    for (const Vec3& arm : {Vec3(0, 0.6, 0.8), Vec3(0, -0.6, -0.8), Vec3(0, 1, 0), Vec3(0, -1, 0)})
        cross.capsules.push_back({Vec3::Zero(), 0.008 * arm, 0.002});
    CapsuleDem dem(parse_container("annulus:0.02,0.2,0.2"), {cross}, 1000.0, {}, {.time_step_s = 1e-9, .gravity_m_per_s2 = Vec3::Zero()});
    dem.add(0, Vec3(0.012 - overlap, 0.0, 0.1), Quaternion::Identity());
    dem.step(1);
    EXPECT_NEAR(dem.energy().elastic_J / one, 1.0, 1e-3);
}

TEST(RoundWalls, AnAnnularDuctCarriesWhatItShould) {
    const double inner = 0.4, outer = 1.0;
    const Container annulus = parse_container("annulus:0.8,2,0.2");
    const packing::Grains nothing(Packing{.container = annulus,
                                          .shapes = {{.id = "s", .capsules = {{Vec3::Zero(), Vec3::Zero(), 1e-6}}}},
                                          .bodies = {{.position_m = Vec3(0.7, 0.0, 0.1)}}});
    const PoreSpace pores = pore_space_of(std::make_shared<const packing::Grains>(nothing), annulus, {0.0, 0.2}, 1.0);
    const double squares = outer * outer - inner * inner,
                 exact = (std::pow(outer, 4) - std::pow(inner, 4) - squares * squares / std::log(outer / inner)) / (8.0 * squares);
    std::vector<double> errors;
    for (const double voxel : {0.2, 0.1, 0.05, 0.025}) {
        const double k = lbm::lbm_permeability(pores, voxel, {.iteration_tolerance = 1e-6, .grids = 1}).fine().permeability_m2;
        errors.push_back(std::abs(k / exact - 1.0));
        EXPECT_LT(errors.back(), 1.5 * voxel * voxel) << voxel;
    }
    std::printf("  errors %.3f %.3f %.3f %.3f %%\n", 100.0 * errors[0], 100.0 * errors[1], 100.0 * errors[2], 100.0 * errors[3]);
    EXPECT_GT(std::log2(errors[0] / errors[3]) / 3.0, 1.6);
}

// No grain is lost, none lies beyond a wall, and the bed ends below its top.
TEST(RoundWalls, PoursIntoAnnuliAndCones) {
    const Shape tetrapod = make_preset(ShapeKind::tetrapod, 0.003, 0.004),
                pellet = make_shape({.kind = ShapeKind::cylinder, .diameter_m = 0.006, .height_m = 0.006});
    const auto pour = [](const Shape& shape, const char* form, pouring::Fill fill, long grains) {
        const Container container = parse_container(form);
        const Folder folder;
        const auto result = pouring::dem::pour_with_capsules({{.shape = shape, .number_fraction = 1.0}}, container,
                                                             {.fill = fill, .grains = grains}, folder.path());
        ASSERT_EQ(result.packing.bodies.size(), static_cast<std::size_t>(grains)) << form;
        const packing::Overlaps overlaps = packing::find_overlaps(result.packing);
        EXPECT_LT(overlaps.largest_with_wall_m, 0.02 * packing::finest_diameter(result.packing)) << form;
        const packing::Grains solid(result.packing);
        const double top = solid.bounds().high.z();
        const double porosity = packing::porosity(solid, container, {0.0, top}, 5000).value;
        std::printf("  %s: %.1f mm high, porosity %.3f\n", form, 1000.0 * top, porosity);
        EXPECT_GT(porosity, 0.3) << form;
        EXPECT_LT(porosity, 0.85) << form;
    };
    pour(tetrapod, "annulus:0.016,0.05,0.1", pouring::Fill::lattice, 40);
    pour(tetrapod, "cone:0.024,0.06,0.08", pouring::Fill::batches, 40);
    pour(tetrapod, "cone:0.05,0.03,0.1", pouring::Fill::batches, 40);
    pour(pellet, "annulus:0.012,0.034,0.1", pouring::Fill::lattice, 12);
    pour(pellet, "cone:0.004,0.05,0.06", pouring::Fill::lattice, 12);  // whose floor holds no grain
}

}  // namespace
}  // namespace porepack::test
