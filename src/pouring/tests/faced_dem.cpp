// Grains with faces in the built-in engine, against what rigid bodies do: rest, sliding, rolling, stacks, conservation.
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "pouring/dem/capsule_dem.hpp"
#include "pouring/dem/piece_rows.hpp"
#include "shapes/config.hpp"
#include "support/helpers.hpp"
#include "vessels/container.hpp"

namespace porepack {
namespace {

constexpr double g = 9.81, pi = std::numbers::pi;

Shape cube(double side) {
    return make_shape({.kind = ShapeKind::cube, .side_m = side});
}
Shape cylinder(double diameter, double height) {
    return make_shape({.kind = ShapeKind::cylinder, .diameter_m = diameter, .height_m = height});
}
Shape ring(double diameter, double inner, double height) {
    return make_shape({.kind = ShapeKind::ring, .diameter_m = diameter, .height_m = height, .inner_diameter_m = inner});
}

Container wide_box() {
    return make_box({1.0, 1.0, 1.0});
}

Quaternion turned(const Vec3& axis, double degrees) {
    return Quaternion(Eigen::AngleAxisd(degrees * pi / 180.0, axis.normalized()));
}

// Steps until all is quiet; the total energy may not grow from one check to the next by more than `allowed`.
double settle(CapsuleDem& dem, double seconds, double dt, double allowed_J) {
    double before = dem.energy().total(), worst = 0.0;
    for (double t = 0.0; t < seconds; t += 200 * dt) {
        dem.step(200);
        const double now = dem.energy().total();
        worst = std::max(worst, now - before);
        before = now;
    }
    EXPECT_LE(worst, allowed_J);
    return dem.rest().kinetic_energy_per_grain_J;
}

TEST(FacedDem, ACubeDroppedFlatOnAnEdgeAndOnACornerComesToRest) {
    const Shape shape = cube(0.01);
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3, .tangential_stiffness_N_per_m = 2.5e3};
    const double to_corner = std::acos(1.0 / std::sqrt(3.0)) * 180.0 / pi;
    for (const Quaternion& pose :
         {Quaternion(1.0, 0.0, 0.0, 0.0), turned(Vec3::UnitX(), 45.2),
          Quaternion(turned(Vec3(1, 2, 0.5), 0.3) * turned(Vec3(1, -1, 0), to_corner)), turned(Vec3(1, 2, 3), 77.0)}) {
        CapsuleDem dem(wide_box(), {shape}, 1000.0, law, {.time_step_s = 2e-5});
        dem.add(0, {0.5, 0.5, 0.012}, pose);
        const double start = dem.energy().total();
        const double kinetic = settle(dem, 1.5, 2e-5, 1e-3 * start);
        EXPECT_LT(kinetic, 1e-6 * dem.grain(0).mass_kg * g * 0.01);
        // Flat on a face: one axis is vertical and the centre lies half a side above the floor, less the overlap of its weight.
        const Body body = dem.pose(0);
        const Vec3 up = body.orientation.conjugate() * Vec3::UnitZ();
        EXPECT_NEAR(up.cwiseAbs().maxCoeff(), 1.0, 1e-8);
        EXPECT_NEAR(dem.centre_of_mass(0).z(), 0.005, 2e-5);
        std::printf("  kinetic %.1e J, height %.7f m, tilt %.1e\n", kinetic, dem.centre_of_mass(0).z(), 1.0 - up.cwiseAbs().maxCoeff());
    }
}

TEST(FacedDem, FiveCubesStayStackedForTwoSeconds) {
    const Shape shape = cube(0.01);
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3, .tangential_stiffness_N_per_m = 2.5e3};
    CapsuleDem dem(wide_box(), {shape}, 1000.0, law, {.time_step_s = 2e-5});
    for (int i = 0; i < 5; ++i)
        dem.add(0, {0.5 + 0.001 * (i % 2), 0.5 - 0.0007 * (i % 3), 0.00502 + 0.01002 * i}, turned(Vec3::UnitZ(), 10.0 * i));
    dem.step(100000);
    for (int i = 0; i < 5; ++i) {
        const Vec3& x = dem.centre_of_mass(static_cast<std::size_t>(i));
        std::printf("  %d: %.6f %.6f %.6f\n", i, x.x() - 0.5 - 0.001 * (i % 2), x.y() - 0.5 + 0.0007 * (i % 3), x.z());
        EXPECT_NEAR(x.x(), 0.5 + 0.001 * (i % 2), 1e-4);
        EXPECT_NEAR(x.y(), 0.5 - 0.0007 * (i % 3), 1e-4);
        EXPECT_NEAR(x.z(), 0.005 + 0.01 * i, 1e-4);
    }
    EXPECT_LT(dem.rest().kinetic_energy_per_grain_J, 1e-8 * dem.grain(0).mass_kg * g * 0.01);
}

// Gravity is tilted instead of the floor.
double travel_on_incline(const Shape& shape, const Quaternion& pose, double height, double degrees, double friction, double seconds) {
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3, .tangential_stiffness_N_per_m = 2.5e3, .wall_friction = friction};
    const double angle = degrees * pi / 180.0;
    CapsuleDem dem(wide_box(), {shape}, 1000.0, law,
                   {.time_step_s = 1e-5, .gravity_m_per_s2 = g * Vec3(std::sin(angle), 0.0, -std::cos(angle))});
    dem.add(0, {0.3, 0.5, height}, pose);
    dem.step(20000);  // the first impact passes
    const double from = dem.centre_of_mass(0).x(), speed = dem.velocity(0).x();
    dem.step(std::lround(seconds / 1e-5));
    return dem.centre_of_mass(0).x() - from - speed * seconds;
}

TEST(FacedDem, SlidingBeginsAtTheAngleOfFriction) {
    for (const double mu : {0.1, 0.3}) {
        const double limit = std::atan(mu) * 180.0 / pi;
        for (const Quaternion& pose : {Quaternion(1.0, 0.0, 0.0, 0.0), turned(Vec3::UnitZ(), 30.0)}) {
            const double rests = travel_on_incline(cube(0.01), pose, 0.005, 0.99 * limit, mu, 0.3);
            const double slides = travel_on_incline(cube(0.01), pose, 0.005, 1.01 * limit, mu, 0.3);
            std::printf("  mu %.1f: %.2e m below, %.2e m above\n", mu, rests, slides);
            EXPECT_LT(std::abs(rests), 1e-6);
            EXPECT_GT(slides, 1e-4);
        }
    }
}

TEST(FacedDem, ACylinderRollsWithTwoThirdsOfGravity) {
    const double degrees = 2.0, seconds = 0.4;
    for (const Shape& shape : {cylinder(0.01, 0.01), ring(0.01, 0.006, 0.01)}) {
        const ShapeMeasures m = measure(shape);
        const double r = 0.5 * bounds_of(PlacedShape{shape}).high.x() * 2.0;
        const double factor = 1.0 / (1.0 + m.inertia_per_density_m5(2, 2) / (m.volume_m3 * r * r));
        const double travel = travel_on_incline(shape, turned(Vec3::UnitX(), 90.0), r, degrees, 0.5, seconds);
        const double expected = 0.5 * factor * g * std::sin(degrees * pi / 180.0) * seconds * seconds;
        std::printf("  factor %.4f: %.6f of %.6f m, ratio %.4f\n", factor, travel, expected, travel / expected);
        EXPECT_NEAR(travel / expected, 1.0, 0.02);
    }
}

TEST(FacedDem, ACylinderRestsOnItsEndAndARingHangsOnARod) {
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3, .tangential_stiffness_N_per_m = 2.5e3};
    {
        CapsuleDem dem(wide_box(), {cylinder(0.01, 0.01)}, 1000.0, law, {.time_step_s = 1e-5});
        dem.add(0, {0.5, 0.5, 0.006}, turned(Vec3::UnitX(), 5.0));
        const double kinetic = settle(dem, 1.0, 1e-5, 1e-9);
        const Vec3 up = dem.pose(0).orientation * Vec3::UnitZ();
        std::printf("  on its end: kinetic %.1e J, tilt %.1e\n", kinetic, 1.0 - up.z());
        EXPECT_NEAR(up.z(), 1.0, 1e-9);
        EXPECT_LT(kinetic, 1e-10);
    }
    {
        const Shape rod = make_preset(ShapeKind::rod, 0.003, 0.06);
        CapsuleDem dem(wide_box(), {rod, ring(0.01, 0.006, 0.01)}, 1000.0, law, {.time_step_s = 1e-5});
        dem.add(0, {0.5, 0.5, 0.1}, turned(Vec3::UnitX(), 90.0));
        dem.hold(0);
        dem.add(1, {0.5, 0.5, 0.0987}, turned(Vec3::UnitX(), 90.0));
        settle(dem, 1.5, 1e-5, 1e-8);
        const Vec3& x = dem.centre_of_mass(1);
        std::printf("  ring at %.6f %.6f %.6f\n", x.x(), x.y(), x.z());
        EXPECT_NEAR(x.z(), 0.1 + 0.0015 - 0.003, 5e-5);
        EXPECT_NEAR(x.x(), 0.5, 5e-4);
    }
}

// Frictionless and elastic in a periodic box.
// Its end lies on the ends of two others, near their rims: their round sides are not in contact.
TEST(FacedDem, ACylinderStandsOnTheRimsOfTwoOthers) {
    const Shape shape = cylinder(0.008, 0.008);
    CapsuleDem dem(wide_box(), {shape}, 1000.0, {.normal_stiffness_N_per_m = 1e4, .tangential_stiffness_N_per_m = 5e3},
                   {.time_step_s = 5e-6});
    dem.add(0, {0.4932, 0.5, 0.1}, Quaternion::Identity());
    dem.add(0, {0.5071, 0.5, 0.1}, Quaternion::Identity());
    dem.hold(0);
    dem.hold(1);
    dem.add(0, {0.5, 0.5, 0.10801}, Quaternion::Identity());
    dem.step(60000);
    EXPECT_LT(dem.rest().largest_overlap_m, 1e-5);
    EXPECT_LT((dem.pose(2).position_m - Vec3(0.5, 0.5, 0.108)).norm(), 2e-5);
}

TEST(FacedDem, AGasKeepsMomentumAndEnergy) {
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3,
                         .tangential_stiffness_N_per_m = 2.5e3,
                         .normal_damping = 0.0,
                         .tangential_damping = 0.0,
                         .friction = 0.0};
    for (const double dt : {4e-6}) {
        CapsuleDem dem(make_box({0.06, 0.06, 0.06}, {true, true, true}),
                       {cube(0.008), cylinder(0.009, 0.008), ring(0.01, 0.006, 0.008), make_preset(ShapeKind::tetrapod, 0.003, 0.006)},
                       1000.0, law, {.time_step_s = dt, .gravity_m_per_s2 = Vec3::Zero()});
        std::mt19937_64 random(7);
        std::uniform_real_distribution<double> unit(-1.0, 1.0);
        for (int i = 0; i < 64; ++i)
            dem.add(static_cast<std::size_t>(i % 4), {0.0075 + 0.015 * (i % 4), 0.0075 + 0.015 * (i / 4 % 4), 0.0075 + 0.015 * (i / 16)},
                    Quaternion(unit(random), unit(random), unit(random), unit(random)).normalized(),
                    {0.5 * unit(random), 0.5 * unit(random), 0.5 * unit(random)});
        const auto momentum = [&] {
            Vec3 sum = Vec3::Zero();
            for (std::size_t i = 0; i < dem.size(); ++i) sum += dem.grain(i % 4).mass_kg * dem.velocity(i);
            return sum;
        };
        const double energy = dem.energy().total();
        const Vec3 before = momentum();
        const core::Stopwatch watch;
        dem.step(std::lround(0.2 / dt));
        const double drift = dem.energy().total() / energy - 1.0;
        std::printf("  dt %.1e: energy %+.1e, momentum %.1e, %.1f s\n", dt, drift, (momentum() - before).norm() / before.norm(),
                    watch.seconds());
        EXPECT_LT((momentum() - before).norm(), 1e-12 * std::sqrt(2.0 * energy * 64.0 * dem.grain(0).mass_kg));
        EXPECT_LT(std::abs(drift), 2e-3);
    }
}

// A ring through which another one passes hangs on it, and falls no farther.
TEST(FacedDem, InterlockedRingsDoNotPassThroughEachOther) {
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3, .tangential_stiffness_N_per_m = 2.5e3};
    const Shape link = ring(0.012, 0.0084, 0.002);
    CapsuleDem dem(wide_box(), {link}, 1000.0, law, {.time_step_s = 4e-6, .gravity_m_per_s2 = Vec3(0, 0, -5.0 * g)});
    dem.add(0, {0.5, 0.5, 0.1}, turned(Vec3::UnitX(), 90.0));
    dem.hold(0);
    dem.add(0, {0.5, 0.5, 0.092}, turned(Vec3::UnitY(), 90.0));
    dem.step(100000);
    const Vec3& x = dem.centre_of_mass(1);
    std::printf("  the lower ring at %.5f %.5f %.5f\n", x.x() - 0.5, x.y() - 0.5, x.z() - 0.1);
    // The inner sides of both rest on each other.
    EXPECT_NEAR(x.z(), 0.1 - 2.0 * 0.0042, 2e-4);
    EXPECT_LT(dem.rest().largest_overlap_m, 1e-4);
}

TEST(FacedDem, ACrossingEndsTheRun) {
    const ContactLaw soft{.normal_stiffness_N_per_m = 50.0, .tangential_stiffness_N_per_m = 25.0};
    CapsuleDem dem(wide_box(), {cube(0.01), cube(0.004)}, 1000.0, soft, {.time_step_s = 1e-5});
    dem.add(0, {0.5, 0.5, 0.1}, Quaternion::Identity());
    dem.hold(0);
    dem.add(1, {0.501, 0.5, 0.11}, turned(Vec3(1, 2, 3), 20.0), {0, 0, -5.0});
    EXPECT_TRUE(
        test::has(test::message_of<NumericalError>([&] { dem.step(2000); }), "grains 0 and 1 overlap by more than 0.4 of the thickness"));
}

TEST(FacedDem, RowsOfPlacesAndWallsAreThoseOfSinglePoints) {
    using namespace pouring::dem;
    for (const auto& pieces : pieces_of({cube(0.006), cylinder(0.006, 0.006), ring(0.007, 0.0042, 0.006)}))
        for (const ContactPiece& piece : pieces) {
            if (piece.kind == ContactPiece::Kind::point) continue;
            PlaceRow row;
            row.points.count = PointRow::most;
            for (std::size_t i = 0; i < row.s.size(); ++i) row.s[i] = static_cast<double>(i) / 15.0;
            place(piece, row);
            const Quaternion pose = turned(Vec3(3, -1, 2), 50.0);
            const Eigen::Matrix3d turn = pose.toRotationMatrix();
            const Vec3 origin(0.004, -0.003, 0.02), normal = Vec3(1, 2, -2) / 3.0;
            DistanceRow plane;
            plane_distances(normal, 0.001, row.points, plane);
            const geometry::VesselWalls::Round rounds[] = {{.radius_m = 0.03},
                                                           {.radius_m = 0.02, .slope = 0.4},
                                                           {.radius_m = 0.03, .slope = -0.7},
                                                           {.radius_m = 0.001, .inside = true}};
            DistanceRow round[4];
            for (int w = 0; w < 4; ++w) round_distances(turn, origin, rounds[w], row.points, round[w]);
            for (int i = 0; i < PointRow::most; ++i) {
                const auto n = static_cast<std::size_t>(i);
                Vec3 tangent;
                const Vec3 at = piece.at(row.s[n], &tangent);
                ASSERT_EQ(at, row.points.at(i));
                ASSERT_EQ(tangent, row.tangents.at(i));
                ASSERT_DOUBLE_EQ(piece.speed(row.s[n]), row.speed[n]);
                EXPECT_NEAR(plane.distance[n], 0.001 + normal.dot(at), 1e-17);
                EXPECT_EQ(plane.outward.at(i), normal);
                const Vec3 x = origin + pose * at;
                EXPECT_NEAR(rounds[0].distance(x), 0.03 - x.head<2>().norm(), 1e-16);
                for (int w = 0; w < 4; ++w) {
                    EXPECT_NEAR(round[w].distance[n], rounds[w].distance(x), 1e-16);
                    EXPECT_LT((round[w].outward.at(i) - pose.conjugate() * rounds[w].normal(x)).norm(), 1e-14);
                }
            }
        }
}

TEST(FacedDem, GivesTheSameBitsOnAnyNumberOfThreadsAndAfterASnapshot) {
    const ContactLaw law{.normal_stiffness_N_per_m = 5e3, .tangential_stiffness_N_per_m = 2.5e3};
    const std::vector<Shape> shapes = {cube(0.006), cylinder(0.006, 0.006), ring(0.007, 0.0042, 0.006),
                                       make_preset(ShapeKind::tetrapod, 0.003, 0.004)};
    const auto filled = [&] {
        CapsuleDem dem(make_cylinder(0.03, 0.1), shapes, 1000.0, law, {.time_step_s = 1e-5, .sleep = true});
        for (int i = 0; i < 24; ++i)
            dem.add(static_cast<std::size_t>(i % 4),
                    {0.006 * (i % 2 == 0 ? 1 : -1), 0.006 * (i / 2 % 2 == 0 ? 1 : -1), 0.008 + 0.011 * (i / 4)},
                    turned(Vec3(1 + i % 3, 2, i % 5), 31.0 * i));
        return dem;
    };
    const auto bytes = [](const CapsuleDem& dem) {
        std::ostringstream out;
        dem.save(out);
        return out.str();
    };
    const auto state = [](const CapsuleDem& dem) {
        std::vector<double> numbers;
        for (std::size_t i = 0; i < dem.size(); ++i) {
            const Body pose = dem.pose(i);
            for (const Vec3& part : {pose.position_m, dem.velocity(i), dem.angular_momentum(i)})
                numbers.insert(numbers.end(), part.data(), part.data() + 3);
            for (int c = 0; c < 4; ++c) numbers.push_back(pose.orientation.coeffs()[c]);
        }
        return numbers;
    };
    std::vector<double> one;
    for (const int threads : {1, 2, 3}) {
        omp_set_num_threads(threads);
        CapsuleDem dem = filled();
        dem.step(3000);
        if (threads == 1)
            one = state(dem);
        else
            EXPECT_TRUE(state(dem) == one) << threads;
    }
    omp_set_num_threads(omp_get_num_procs());
    CapsuleDem dem = filled(), again = filled();
    dem.step(1500);
    std::istringstream half(bytes(dem));
    again.load(half, "half");
    again.step(1500);
    EXPECT_TRUE(state(again) == one);
}

}  // namespace
}  // namespace porepack
