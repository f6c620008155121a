// Grains that enclose a void which counts as solid: no measure of the pores may see it. The grains are tetrahedra with closed faces. Their
// solid is known without any search for cavities: the capsules, and the tetrahedron of their axes, whose faces the capsules cover.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "scans/scanner.hpp"
#include "shapes/shape.hpp"
#include "support/helpers.hpp"
#include "tortuosity/tortuosity.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using Vec2 = Eigen::Vector2d;
using tortuosity::GeometricPaperResult;

constexpr double radius = 1.0;  // of the capsules

// Axes of 3.03 radii, as at sphericity 0.87: faces are closed up to 2 sqrt(3), cavities exist from 2 sqrt(2) on.
Packing closed_tetrahedra(const std::vector<Vec3>& places, unsigned seed) {
    Packing packing{.container = parse_container("box:9,9,9"),
                    .shapes = {make_preset(ShapeKind::tetrahedron, 2.0 * radius, 3.03 * radius)},
                    .bodies = {},
                    .overlap_allowed = true};
    find_cavities(packing.shapes[0]);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (const Vec3& place : places)
        packing.bodies.push_back({.shape = 0,
                                  .position_m = place,
                                  .orientation = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized()});
    return packing;
}

struct Tetrahedron {
    std::array<Vec3, 4> corner;
    [[nodiscard]] bool contains(const Vec3& point, double r) const {
        bool inside = true;
        for (std::size_t i = 0; i < 4; ++i) {
            const Vec3 &a = corner[i], &b = corner[(i + 1) % 4], &c = corner[(i + 2) % 4], &opposite = corner[(i + 3) % 4];
            const Vec3 normal = (b - a).cross(c - a);
            inside = inside && normal.dot(point - a) * normal.dot(opposite - a) > 0.0;
            for (std::size_t j = i + 1; j < 4; ++j) {
                const Vec3 edge = corner[j] - a;
                const double t = std::clamp((point - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
                if ((point - a - t * edge).norm() < r) return true;
            }
        }
        return inside;
    }
};

std::vector<Tetrahedron> tetrahedra_of(const Packing& packing) {
    std::vector<Tetrahedron> all;
    for (const Body& body : packing.bodies) {
        std::vector<Vec3> ends;
        for (const Capsule& capsule : world_capsules(packing, body))
            for (const Vec3& end : {capsule.a, capsule.b})
                if (std::none_of(ends.begin(), ends.end(), [&](const Vec3& known) { return (known - end).norm() < 1e-9; }))
                    ends.push_back(end);
        EXPECT_EQ(ends.size(), 4U);
        all.push_back({{ends[0], ends[1], ends[2], ends[3]}});
    }
    return all;
}

bool solid(const std::vector<Tetrahedron>& grains, const Vec3& point, double r = radius) {
    return std::any_of(grains.begin(), grains.end(), [&](const Tetrahedron& grain) { return grain.contains(point, r); });
}

constexpr double step = 0.01;

// Distance to the closest void point in the plane, in 360 directions and steps of `step`: too large by at most the step and the turn.
double distance_to_void(const std::vector<Tetrahedron>& grains, const Vec3& from) {
    double best = 10.0;
    for (int i = 0; i < 360; ++i) {
        const Vec3 direction(std::cos(std::numbers::pi * i / 180.0), std::sin(std::numbers::pi * i / 180.0), 0.0);
        for (double at = 0.0; at < best; at += step)
            if (!solid(grains, from + at * direction)) best = at;
    }
    return best;
}

// Every point of every path is void, and no void point of its slice is closer to the dot.
TEST(FilledCavity, DotsMoveToTheClosestPointOutsideTheWholeGrain) {
    const std::vector<std::vector<Vec3>> beds = {{{4.25, 4.25, 4.5}}, {{3.5, 4.25, 4.5}, {5.9, 4.9, 4.7}, {4.6, 5.1, 6.1}}};
    for (std::size_t bed = 0; bed < beds.size(); ++bed) {
        const Packing packing = closed_tetrahedra(beds[bed], 7 + static_cast<unsigned>(bed));
        const auto grains = tetrahedra_of(packing);
        const GeometricPaperResult result = geometric_paper_exact(
            Grains(packing), packing.container, {0.0, 9.0}, {.dot_spacing_m = 0.5, .slice_spacing_m = 0.5, .largest_angle_deg = 180.0});
        ASSERT_EQ(result.paths, 324);
        long moved = 0, in_cavity_of_one = 0, missed = 0;
        for (const auto& path : result.paths_m)
            for (const Vec3& point : path) {
                const Vec3 dot(path.front().x(), path.front().y(), point.z());  // the lowest slice has no grain
                ASSERT_FALSE(solid(grains, point, radius * (1.0 - 1e-6))) << point.transpose();
                if (!solid(grains, dot)) {
                    ASSERT_EQ(point, dot);
                    continue;
                }
                ++moved;
                in_cavity_of_one += signed_distance(Grains(packing).images()[0].capsules, dot) > 0.0 ? 1 : 0;
                const double expected = distance_to_void(grains, dot), found = (point - dot).norm();
                // The search looks in 96 directions: it can miss a notch that is seen under less than 3.75 degrees, as between grains.
                missed += found > expected + 1e-6 ? 1 : 0;
                ASSERT_LE(found, expected + 0.1) << dot.transpose();
                // The step, and the turn by half a degree at up to 3 radii where the closest point is a corner.
                ASSERT_GE(found, expected - step - 0.03) << dot.transpose();
            }
        EXPECT_GT(moved, 150);
        EXPECT_LE(missed, moved / 200);
        EXPECT_GT(in_cavity_of_one, 0) << "no dot lies in a cavity: the test would show nothing";
    }
}

// The images of slices are made from vertical lines, in which cavities were always solid.
TEST(FilledCavity, DotsOnPixelsAreThoseOnSliceImages) {
    const test::Folder folder;
    std::vector<Vec3> places;
    for (int i = 0; i < 8; ++i) places.emplace_back(2.25 + 4.5 * (i % 2), 2.25 + 4.5 * (i / 2 % 2), 2.25 + 4.5 * (i / 4));
    const Packing packing = closed_tetrahedra(places, 19);
    const Grains grains(packing);
    write_slices(folder.path() / "slices", grains, packing.container, {0.0, 9.0}, 0.1, 0.1);
    const GeometricPaperResult images = geometric_paper_on_slices(read_slices(folder.path() / "slices"), {.dot_spacing_m = 0.45});
    const GeometricPaperResult laid =
        geometric_paper_exact(grains, packing.container, {0.0, 9.0}, {.dot_spacing_m = 0.45, .slice_spacing_m = 0.1, .dot_pixel_m = 0.1});
    std::printf("  pixels of the grains %.4f, images %.4f\n", laid.value, images.value);
    // The lowest slices differ by half a slice, which changes single paths; with cavities as void the excess differs by a third.
    EXPECT_NEAR((laid.value - 1.0) / (images.value - 1.0), 1.0, 0.05);
}

// A sphere that fills the void inside, and lies in the solid otherwise, makes the same scan, without any cavity.
TEST(FilledCavity, ScansShowItAsSolid) {
    Packing packing = closed_tetrahedra({{4.5, 4.5, 4.5}, {2.0, 6.5, 7.0}}, 23);
    const ScannerConfig config{.voxel_size_m = 0.15, .views = 60, .tilt_deg = 5.0};
    const SimulatedScan scan = scan_packing(packing, {3.9, 5.1}, config);
    packing.shapes[0].cavity = Cavity::open;
    const SimulatedScan open = scan_packing(packing, {3.9, 5.1}, config);
    // From the centre, the faces of the axes' tetrahedron are L / (2 sqrt 6) away.
    packing.shapes[0].capsules.push_back({Vec3::Zero(), Vec3::Zero(), 3.03 / std::sqrt(24.0)});
    const SimulatedScan plugged = scan_packing(packing, {3.9, 5.1}, config);
    double difference = 0.0, of_open = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < scan.values.size(); ++i) {
        largest = std::max(largest, std::abs(static_cast<double>(scan.values[i])));
        difference = std::max(difference, std::abs(static_cast<double>(scan.values[i] - plugged.values[i])));
        of_open = std::max(of_open, std::abs(static_cast<double>(open.values[i] - plugged.values[i])));
    }
    EXPECT_LT(difference, 1e-4 * largest);  // the rounding of the chords' sums
    EXPECT_GT(of_open, 1e-2 * largest) << "the scan does not resolve the void: the test would show nothing";
}

TEST(FilledCavity, TheDistanceToTheGrainsIsNegativeInIt) {
    const Packing packing = closed_tetrahedra({{4.5, 4.5, 4.5}}, 3);
    const Grains filled(packing);
    // The centre is L/(2 sqrt 2) from the axes.
    EXPECT_NEAR(*filled.distance(Vec3::Constant(4.5), 9.0), -(3.03 / std::sqrt(8.0) - 1.0), 1e-9);
    Packing other = packing;
    other.shapes[0].cavity = Cavity::open;
    EXPECT_NEAR(*Grains(other).distance(Vec3::Constant(4.5), 9.0), 3.03 / std::sqrt(8.0) - 1.0, 1e-9);
}

}  // namespace
}  // namespace porepack
