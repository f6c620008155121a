// Walls of segmented images: of voxelised packings whose k is known from their exact walls.
#include "scans/ball_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "analysis/flow.hpp"
#include "pore_space/gray_measures.hpp"
#include "vessels/container.hpp"

namespace porepack {
namespace {

using geometry::PhaseImage;
using pore_space::PoreSpace;
using shapes::Vec3;

constexpr double diameter = 0.01;

// Grains at random places and turns, which overlap, in a periodic box.
packing::Packing boolean_model(const shapes::Shape& shape, int grains, double side, unsigned seed) {
    packing::Packing packing{.container = vessels::make_box({side, side, side}, {true, true, true}), .shapes = {shape}, .bodies = {}};
    packing.overlap_allowed = true;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0.0, side);
    std::normal_distribution<double> turn;
    for (int n = 0; n < grains; ++n) {
        const Vec3 at(place(random), place(random), place(random));
        const double w = turn(random), x = turn(random), y = turn(random), z = turn(random);
        packing.bodies.push_back({.shape = 0, .position_m = at, .orientation = shapes::Quaternion(w, x, y, z).normalized()});
    }
    return packing;
}

PoreSpace space_of_balls(const PhaseImage& image, const vessels::Container& container) {
    return pore_space::pore_space_of(scans::walls_of_balls(image, container).solid, container, {0.0, container.height()}, "test");
}

struct Found {
    double k, low, high;
};
Found flow_in(const PoreSpace& space, double voxel_size_m, long grids = 3) {
    const lbm::LbmConfig config{.grids = grids, .fields = lbm::FieldFiles::none};
    const auto result = analysis::compute_flow(space, {.voxel_size_m = voxel_size_m}, config).outcome.result;
    const auto interval = result.permeability.interval_m2.value_or(core::Interval{});
    return {result.permeability.m2, interval.low, interval.high};
}

TEST(BallWalls, KeepTheVoxelsAndTheirVolume) {
    const packing::Packing rods = boolean_model(shapes::make_preset(shapes::ShapeKind::rod, diameter, 2.0 * diameter), 8, 0.03, 3);
    const PhaseImage image = pore_space::pore_space_of(rods).voxelise_at(1e-3);
    const scans::GrayInput walls = scans::walls_of_balls(image, rods.container);
    std::size_t solid = 0;
    for (std::size_t cell = 0; cell < image.phase.size(); ++cell) {
        const bool grain = image.phase[cell] == geometry::Phase::grain;
        EXPECT_EQ(walls.solid->image()->at(cell) > walls.notes.level, grain) << cell;
        solid += grain ? 1 : 0;
    }
    const double fraction = static_cast<double>(solid) / static_cast<double>(image.phase.size());
    EXPECT_NEAR(pore_space::solid_fraction(*walls.solid, rods.container), fraction, 2e-3);
    EXPECT_TRUE(scans::has_walls_of_balls(*walls.solid));
}

// Between plates of whole voxels the walls are exact, whichever way the slit lies.
TEST(BallWalls, ASlitIsExact) {
    constexpr int across = 32, open = 16;
    for (const int normal : {0, 1}) {
        const auto n = static_cast<std::size_t>(normal);
        PhaseImage image{.grid = {.cells = {4, 4, 4}, .spacing_m = {1e-3, 1e-3, 1e-3}}, .phase = {}, .notes = {}};
        image.grid.cells[n] = across;
        for (std::size_t cell = 0; cell < image.grid.size(); ++cell)
            image.phase.push_back(image.grid.place(cell)[n] < open ? geometry::Phase::pore : geometry::Phase::grain);
        const vessels::Container box =
            vessels::make_box({1e-3 * image.grid.cells[0], 1e-3 * image.grid.cells[1], 1e-3 * image.grid.cells[2]}, {true, true, true});
        const double width = open * 1e-3, exact = width * width / 12.0 * open / across;
        EXPECT_NEAR(flow_in(space_of_balls(image, box), 1e-3, 1).k / exact, 1.0, 3e-3) << "normal " << normal;
    }
}

// At 10 and 20 voxels per diameter: within 3 % and 2.5 %, where half-way walls are farther off; and the interval holds the exact k.
TEST(BallWalls, PermeabilityOfVoxelisedGrains) {
    const shapes::Shape rod = shapes::make_preset(shapes::ShapeKind::rod, diameter, 2.0 * diameter),
                        tetrapod = shapes::make_preset(shapes::ShapeKind::tetrapod, diameter, 1.2 * diameter);
    for (const auto& packing : {boolean_model(rod, 7, 0.027, 5), boolean_model(tetrapod, 3, 0.027, 6)}) {
        const PoreSpace space = pore_space::pore_space_of(packing);
        const double exact = flow_in(space, diameter / 15.0).k;
        for (const auto& [voxels, largest] : {std::pair(10, 0.03), {20, 0.025}}) {
            const double voxel_size_m = diameter / voxels;
            const PhaseImage image = space.voxelise_at(voxel_size_m);
            const Found found = flow_in(space_of_balls(image, packing.container), voxel_size_m);
            const PoreSpace half_way = pore_space::pore_space_of(image, packing.container, space.section, "test");
            const double error = found.k / exact - 1.0, error_half_way = flow_in(half_way, voxel_size_m, 1).k / exact - 1.0;
            EXPECT_NEAR(error, 0.0, largest) << packing.shapes.front().id << ", " << voxels << " voxels";
            EXPECT_LT(std::abs(error), std::abs(error_half_way)) << packing.shapes.front().id << ", " << voxels << " voxels";
            EXPECT_LT(found.low, exact);
            EXPECT_GT(found.high, exact);
        }
    }
}

TEST(BallWalls, ThinPartsAreCounted) {
    PhaseImage image{.grid = {.cells = {20, 8, 8}, .spacing_m = {1.0, 1.0, 1.0}}, .phase = {}, .notes = {}};
    // Along x: a plate of two voxels, pores of eight, a plate of six, pores of four.
    for (std::size_t cell = 0; cell < image.grid.size(); ++cell) {
        const int i = image.grid.place(cell)[0];
        image.phase.push_back(i < 2 || (i >= 10 && i < 16) ? geometry::Phase::grain : geometry::Phase::pore);
    }
    const scans::ThinParts thin = scans::thin_parts(image, {true, true, true});
    EXPECT_DOUBLE_EQ(thin.solid, 0.25);
    EXPECT_DOUBLE_EQ(thin.pores, 0.0);
}

}  // namespace
}  // namespace porepack
