// Grains with faces in voxels and flows: porosity over random poses, channels and ducts between boxes at odd angles, square rods, thin
// walls of rings, and what the rounding changes.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "scans/scanner.hpp"
#include "shapes/config.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using namespace test;

Shape shape_of(const std::shared_ptr<const RoundedBody>& body) {
    return {.id = "grain", .body = body};
}

// Of voxels whose middle is solid: the error against the exact volume, over poses, falls with the square of the voxel.
TEST(FacedVoxels, PorosityIsOfSecondOrderOverRandomPoses) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const std::vector<Shape> shapes = {make_shape({.kind = ShapeKind::cube, .side_m = 0.5}),
                                       make_shape({.kind = ShapeKind::ring, .diameter_m = 0.6, .height_m = 0.5, .inner_diameter_m = 0.4}),
                                       make_shape({.kind = ShapeKind::lobed, .diameter_m = 0.6, .height_m = 0.5, .lobe_diameter_m = 0.32})};
    for (const Shape& shape : shapes) {
        const double exact = measure(shape).volume_m3;
        std::array<double, 3> squares{};
        constexpr int poses = 200;
        for (int pose = 0; pose < poses; ++pose) {
            Packing packing{.container = parse_container("box:1,1,1:periodic"), .shapes = {shape}, .bodies = {}};
            const Vec3 at(unit(random), unit(random), unit(random));
            packing.bodies.push_back(
                {.position_m = at, .orientation = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized()});
            const Grains grains(packing);
            for (std::size_t i = 0; i < 3; ++i) {
                const double voxel = 0.1 / std::pow(2.0, static_cast<double>(i));
                const VoxelPlan plan = plan_voxels(packing.container, {0.0, 1.0}, voxel, {}, 1.0);
                const PhaseImage image = voxelise(grains, packing.container, {0.0, 1.0}, plan.grid);
                const auto cells = static_cast<double>(std::count(image.phase.begin(), image.phase.end(), Phase::grain));
                const double solid = cells / static_cast<double>(image.phase.size());
                squares[i] += std::pow(solid / exact - 1.0, 2) / poses;
            }
        }
        const double coarse = std::sqrt(squares[0]), fine = std::sqrt(squares[2]), order = std::log2(coarse / fine) / 2.0;
        std::printf("  %-6s rms %.2e %.2e %.2e, order %.2f\n", shape.id.c_str(), coarse, std::sqrt(squares[1]), fine, order);
        EXPECT_GE(order, 1.8) << shape.id;
    }
}

// Walls of boxes without end: the solid with |n.x - m| < thickness / 2 for all whole m, in a box of periods 1 / n along each axis.
Packing walls_across(const std::vector<Vec3>& normals, const Vec3& box, double thickness, double shift) {
    Packing packing{.container = make_box(box, {true, true, true}), .shapes = {}, .bodies = {}};
    // Long enough to reach through the box in every image, and no longer, for the sake of time.
    const bool upright = normals.front().z() == 0.0;
    const double reach = (upright ? 2.5 : 1.2) * box.norm();
    packing.shapes.push_back(shape_of(make_polyhedron(box_size({thickness, 2.0 * reach, upright ? 2.0 * box.z() : 2.0 * reach}, 0.0))));
    for (const Vec3& normal : normals) {
        const Vec3 middle = 0.5 * box;
        const double along = normal.dot(middle), nearest = std::round(along - shift) + shift;
        packing.bodies.push_back(
            {.position_m = middle + (nearest - along) * normal, .orientation = Quaternion::FromTwoVectors(Vec3::UnitX(), normal)});
    }
    return packing;
}

KnownFlow between_walls(const char* name, Packing packing, double k, double width) {
    KnownFlow known{.name = name, .packing = std::move(packing), .permeability_m2 = k, .diameter_m = width};
    known.container = known.packing.container;
    known.solid = std::make_shared<const Grains>(known.packing);
    return known;
}

double order_of(const KnownFlow& known, const std::array<double, 3>& cells) {
    std::array<double, 3> errors{};
    for (std::size_t i = 0; i < 3; ++i) errors[i] = error_of(known, cells[i], {.iteration_tolerance = 1e-8, .grids = 1});
    const double order = std::log(std::abs(errors[0] / errors[2])) / std::log(cells[2] / cells[0]);
    std::printf("  %-28s %+.3f %+.3f %+.3f %%, order %.2f\n", known.name.c_str(), 100 * errors[0], 100 * errors[1], 100 * errors[2], order);
    EXPECT_LT(std::abs(errors[2]), 0.01);
    return order;
}

TEST(FacedFlow, ChannelsAndDuctsBetweenBoxesAreOfSecondOrder) {
    const double wall = 0.4, gap = 1.0 - wall;
    const double channel = gap * gap * gap / 12.0, duct = 0.0351443 * std::pow(gap, 4);
    // Upright, with the angle of a triangle 3-4-5; and oblique: the flow along z has the part 1 - n_z^2 of it.
    const Vec3 upright(0.6, 0.8, 0.0), oblique = Vec3(2.0, 3.0, 6.0) / 7.0;
    EXPECT_GE(order_of(between_walls("upright channel", walls_across({upright}, {1.0 / 0.6, 1.0 / 0.8, 1.0 / 12}, wall, 0.3), channel, gap),
                       {12.0, 24.0, 36.0}),
              1.8);
    EXPECT_GE(order_of(between_walls("oblique channel", walls_across({oblique}, oblique.cwiseInverse(), wall, 0.3),
                                     channel * (1.0 - oblique.z() * oblique.z()), gap),
                       {10.0, 20.0, 30.0}),
              1.8);
    EXPECT_GE(order_of(between_walls("square duct", walls_across({upright, Vec3(-0.8, 0.6, 0.0)}, {5.0, 5.0, 0.1}, wall, 0.3), duct, gap),
                       {10.0, 20.0, 30.0}),
              1.8);
}

// Square rods, half a pitch wide, in a square array. Independent values: finite differences on grids along the rods' sides (a staggered
// grid across, Poisson's equation along), extrapolated: 0.01302 and 0.02627 to about 1e-5. At the rods' edges the velocity is not smooth:
// the order is below two for every method.
TEST(FacedFlow, SquareRodsAgreeWithFiniteDifferences) {
    for (const auto& [axis, k] : {std::pair(Axis::x, 0.01302), std::pair(Axis::z, 0.02627)}) {
        const double cells = 60;
        Packing packing{.container = make_box({1.0, 1.0, 0.2}, {true, true, true}),
                        .shapes = {shape_of(make_polyhedron(box_size({0.5, 0.5, 3.0}, 0.0)))},
                        .bodies = {{.position_m = {0.513, 0.487, 0.05}}}};
        KnownFlow known = between_walls("square rods", std::move(packing), k, 0.5);
        known.direction = axis;
        const LbmResult result = solve(known, cells, {.iteration_tolerance = 1e-6});
        const auto interval = result.interval_m2().value();
        std::printf("  along %s: k %.5f (%.5f to %.5f), expected %.5f\n", std::string(name_of(axis)).c_str(), result.permeability_m2,
                    interval.low, interval.high, k);
        EXPECT_NEAR(result.permeability_m2 / k, 1.0, 0.01);
        EXPECT_LE(interval.low, 1.002 * k);
        EXPECT_GE(interval.high, 0.998 * k);
    }
}

// A cylinder that is rounded to a sphere makes the scan of a sphere; others, an image of their volume.
TEST(FacedScan, IsThatOfTheExactGrain) {
    const ScannerConfig config{
        .voxel_size_m = 0.05, .views = 160, .counts = 0.0, .blur_voxels = 0.0, .gain_error = 0.0, .one_energy = true, .tilt_deg = 4.0};
    const auto scan_of = [&](const Shape& shape) {
        Packing packing{.container = parse_container("cylinder:3,3"), .shapes = {shape}, .bodies = {}};
        packing.bodies.push_back(
            {.position_m = {0.3, -0.2, 1.4}, .orientation = Quaternion(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()))});
        return scan_packing(packing, {0.5, 2.3}, config);
    };
    const SimulatedScan sphere = scan_of(make_preset(ShapeKind::sphere, 1.0, 0.0)),
                        rounded = scan_of(shape_of(make_ring({.diameter_m = 1.0, .height_m = 1.0, .rounding_m = 0.5})));
    double difference = 0.0;
    for (std::size_t i = 0; i < sphere.values.size(); ++i)
        difference = std::max(difference, std::abs(static_cast<double>(sphere.values[i] - rounded.values[i])));
    EXPECT_LT(difference, 1e-6);
    // The attenuation of the grains is 3 over the container's width.
    for (const Shape& shape : {make_shape({.kind = ShapeKind::cube, .side_m = 0.9}),
                               make_shape({.kind = ShapeKind::ring, .diameter_m = 1.0, .height_m = 0.8, .inner_diameter_m = 0.5})}) {
        const SimulatedScan scan = scan_of(shape);
        const auto solid = std::count_if(scan.values.begin(), scan.values.end(), [](float value) { return value > 0.5F; });
        EXPECT_NEAR(static_cast<double>(solid) * 1.25e-4 / measure(shape).volume_m3, 1.0, 0.03) << shape.id;
    }
}

}  // namespace
}  // namespace porepack
