// Periodic boxes of which no voxel size near the asked one divides all sides: each side is rounded to whole voxels, and the box is
// stretched.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "lbm/inertia.hpp"
#include "lbm/permeability.hpp"
#include "support/helpers.hpp"
#include "support/known_flows.hpp"
#include "tortuosity/tortuosity.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using namespace test;

Packing spheres(const Vec3& size, double radius, const std::vector<Vec3>& centres, bool periodic_z = true) {
    Packing packing{.container = vessels::make_box(size, {true, true, periodic_z}),
                    .shapes = {{.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), radius}}}},
                    .bodies = {}};
    for (const Vec3& centre : centres) packing.bodies.push_back({.shape = 0, .position_m = centre});
    return packing;
}

struct Box {
    const char* name;
    Packing packing;
    double permeability_m2;       // along z; reference
    double reference_error;       // relative
    std::vector<double> asked_m;  // voxel sizes
};

// References: one grid each with 15, 30, 45 and 60 voxels along the smallest side (8 to 32 for 7 : 4), where the first two boxes need no
// stretch, extrapolated with order 2. The last two grids of each give values that differ by less than the error stated here; the third box
// is stretched by 0.15 to 0.23 % on them.
std::vector<Box> boxes() {
    return {{"26 : 26 : 15",
             spheres({2.6, 2.6, 1.5}, 0.56, {{0.41, 0.63, 0.37}, {1.78, 0.52, 0.92}, {0.87, 1.83, 1.13}, {2.11, 1.94, 0.29}}),
             0.02151,
             0.001,
             {0.1, 0.05}},
            {"7 : 4 : 7", spheres({1.75, 1.0, 1.75}, 0.45, {{0.31, 0.27, 0.44}, {1.22, 0.71, 1.29}}), 0.01814, 0.001, {0.125, 0.1, 0.06}},
            {"260 : 190 : 147",
             spheres({2.6, 1.9, 1.4717}, 0.5, {{0.41, 0.63, 0.37}, {1.78, 0.52, 0.92}, {0.87, 1.43, 1.13}, {2.11, 1.34, 0.29}}),
             0.01771,
             0.004,
             {0.12, 0.09, 0.0777}}};
}

TEST(PeriodicBoxes, KIsInItsIntervalAndAllGridsDiffer) {
    for (const Box& box : boxes())
        for (const double asked : box.asked_m) {
            const PoreSpace space = pore_space_of(box.packing);
            const LbmResult result = lbm_permeability(space, asked, {.fields = FieldFiles::none});
            double strain = 0.0;
            ASSERT_GE(result.grids.size(), 3U) << box.name;
            for (std::size_t i = 0; i < result.grids.size(); ++i) {
                const LbmGridResult& grid = result.grids[i];
                if (i > 0) EXPECT_LT(1.02 * grid.voxel_size_m, result.grids[i - 1].voxel_size_m) << box.name << ", " << asked;
                if (i + 3 >= result.grids.size()) strain = std::max(strain, strain_of(grid.stretch));
                // Boxes of whole cubes of the same volume.
                for (std::size_t a = 0; a < 3; ++a) {
                    const double factor = grid.stretch ? (*grid.stretch)[a] : 1.0;
                    EXPECT_NEAR(grid.cells[a] * grid.voxel_size_m / (factor * space.container.size()[static_cast<int>(a)]), 1.0, 1e-12);
                }
                if (grid.stretch) EXPECT_NEAR((*grid.stretch)[0] * (*grid.stretch)[1] * (*grid.stretch)[2], 1.0, 1e-12);
            }
            ASSERT_TRUE(result.half_width);
            EXPECT_DOUBLE_EQ(result.half_width->stretch_m2, 2.0 * strain * result.fine().permeability_m2);
            const double k = box.permeability_m2, half = result.half_width->sum();
            std::printf("  %s, %.4g m: k %+.2f %% off, half width %.2f %%, stretch %.2f %%\n", box.name, asked,
                        100.0 * (result.permeability_m2 / k - 1.0), 100.0 * half / k, 100.0 * strain);
            EXPECT_NEAR(result.permeability_m2, k, half + box.reference_error * k) << box.name << ", " << asked;
            EXPECT_LT(half, 0.08 * k) << "the widest, 7.3 %, has 4, 5 and 8 voxels along the shortest side";
        }
}

// What the part `stretch` of the interval of k claims, with ten times the usual stretch: also the worst case, a slit along the flow, whose
// k changes by exactly the square of the factor of its width.
TEST(PeriodicBoxes, KOfAStretchedArrayChangesLessThanTwiceTheStretch) {
    const std::vector<KnownFlow> arrays = {
        sphere_array(0.5, 37.0108, simple_cubic()), sphere_array(0.4, 23.10930, body_centred()),
        cylinder_array(0.3, 102.881, 0.25, Vec3(0.5, 0.5, 0.0), Axis::x),
        duct(
            "slit", [](double x, double) { return 0.25 - std::abs(x - 0.5); }, 0.5, 0.5 * 0.5 * 0.5 / 12.0)};
    for (const KnownFlow& array : arrays)
        for (const Stretch& sides : {Stretch{1.1, 1, 1}, Stretch{1, 1, 1.1}, Stretch{1.1, 1, 1.1}, Stretch{1, 1.1, 1.1}}) {
            if (array.name == "slit" && sides[2] != 1.0) continue;  // a quarter as high as wide
            const double scale = std::cbrt(sides[0] * sides[1] * sides[2]);
            const auto solve = [&](const PoreSpace& space) {
                return lbm_permeability(space, 0.05, {.direction = array.direction, .grids = 1, .fields = FieldFiles::none})
                    .permeability_m2;
            };
            const PoreSpace space = array.space();
            const double change = std::log(solve(space.stretched(sides)) / (scale * scale) / solve(space));
            double largest = 0.0;
            for (const double side : sides) largest = std::max(largest, std::abs(std::log(side / scale)));
            EXPECT_LT(std::abs(change), 2.02 * largest) << array.name;             // the slit reaches 2, and its discretisation changes
            if (array.name == "slit") EXPECT_GT(std::abs(change), 1.7 * largest);  // 20 and 22 voxels: k differs by 1 %
        }
}

// As far as 0.65 and 1.55 times the asked size.
TEST(PeriodicBoxes, SidesWithACommonSizeUseIt) {
    const auto plan = [](const char* box, double asked) { return plan_voxels(parse_container(box), {0, 1}, asked, {}, 1.0); };
    for (const auto& [box, asked, size] : {std::tuple{"box:2.6,2.6,1.5:periodic", 0.07, 0.1},
                                           {"box:2.6,2.6,1.5:periodic", 0.15, 0.1},
                                           {"box:7,4,7:periodic", 0.4, 1.0 / 3.0},
                                           {"box:1,1.5,1:periodic", 0.3, 0.25}}) {
        const VoxelPlan found = plan(box, asked);
        EXPECT_NEAR(found.voxel_size_m, size, 1e-12) << box;
        for (const double spacing : found.grid.spacing_m) EXPECT_EQ(spacing, found.voxel_size_m) << "cubes";
    }
}

TEST(PeriodicBoxes, EverySizeIsFoundOrTheMessageNamesOneThatWorks) {
    int stretched = 0, refused = 0;
    for (const char* text : {"box:2.6,2.6,1.5:periodic", "box:7,4,7:periodic", "box:1,0.73,1:periodic", "box:1.618,1,2.7183:periodic"})
        for (double asked = 0.011; asked < 0.99; asked *= 1.0371) {
            const Container box = parse_container(text);
            const auto plan = [&](double size) { return plan_voxels(box, {0, box.height()}, size, {}, 1.0); };
            std::string message;
            double size = asked;
            try {
                size = plan(asked).voxel_size_m;
                EXPECT_GT(size, 0.65 * asked) << text;
                EXPECT_LT(size, 1.55 * asked) << text;
            } catch (const UserError& refusal) {
                ++refused;
                EXPECT_LT(box.size().minCoeff(), 4.0 * asked) << text << ", " << asked;
                const std::string said = refusal.what();
                ASSERT_TRUE(has(said, " m is the nearest size that fits")) << said;
                const std::size_t end = said.find(" m is the nearest"), start = said.find_last_of(" \n", end - 1) + 1;
                size = std::stod(said.substr(start, end - start));
            }
            const VoxelPlan found = plan(size);  // must not throw
            EXPECT_NEAR(found.voxel_size_m / size, 1.0, 1e-5) << "six digits are printed; " << text << ", " << asked;
            for (int axis = 0; axis < 3; ++axis) {
                const auto a = static_cast<std::size_t>(axis);
                EXPECT_NEAR(found.grid.cells[a] * found.grid.spacing_m[a], box.size()[axis], 1e-9);
                EXPECT_NEAR(found.grid.spacing_m[a] / found.voxel_size_m, 1.0, 0.031) << text << ", " << asked;  // 1 / 0.97
            }
            stretched += stretch_to_cubes(found.grid) ? 1 : 0;
        }
    EXPECT_GT(stretched, 100);
    EXPECT_GT(refused, 0);
    std::printf("  %d sizes with stretched boxes, %d refused\n", stretched, refused);
}

// A box that is periodic in x and y alone, of 26 : 15: the height stays.
TEST(PeriodicBoxes, WithWallsAlongZKeepTheirHeight) {
    const Packing packing = spheres({2.6, 1.5, 3.0}, 0.5,
                                    {{0.41, 0.63, 0.6}, {1.78, 0.52, 0.92}, {0.87, 1.43, 1.5}, {2.11, 1.34, 2.1}, {1.0, 0.3, 2.4}}, false);
    const PoreSpace space = pore_space_of(packing).with_section({0.5, 2.5}).with_ends(Ends::in_situ);
    const LbmResult result = lbm_permeability(space, 1.5 / 8, {.grids = 1, .fields = FieldFiles::none});
    ASSERT_TRUE(result.fine().stretch);
    EXPECT_EQ((*result.fine().stretch)[2], 1.0);
    EXPECT_EQ(result.fine().cells[0], 14);
    EXPECT_EQ(result.fine().cells[1], 8);
    EXPECT_NEAR(result.permeability_m2 / 0.02575, 1.0, 0.03);  // grids of 15 and 30 voxels, extrapolated; 5 voxels per diameter
}

// Voxels that are no cubes: the tortuosities see the box as it is.
TEST(PeriodicBoxes, TortuositiesUseTheBoxAsItIs) {
    const PoreSpace space = pore_space_of(boxes()[2].packing);
    for (const double asked : {0.12, 0.07}) ASSERT_TRUE(stretch_to_cubes(space.plan_at(asked).grid));
    const auto shortest = [&](double size) { return tortuosity::shortest_path(space, size, Axis::z, 100000).value; };
    // Paths are pulled taut around exact grains; the voxels only choose the side on which a path passes a grain.
    EXPECT_NEAR(shortest(0.12) / shortest(0.07), 1.0, 0.01);
    // The limits from voxels of 0.05 to 0.1 are 1.1497 to 1.1502; with the conductances of cubes they were 1.136 to 1.174.
    for (const double asked : {0.12, 0.07}) {
        const auto found = tortuosity::diffusive_tortuosity(space, asked, Axis::z).interval();
        ASSERT_TRUE(found);
        EXPECT_LT(found->low, 1.1502) << asked;
        EXPECT_GT(found->high, 1.1502) << asked;
        EXPECT_LT(found->high - found->low, 0.01) << asked;
    }
}

TEST(PeriodicBoxes, FlowsWithInertiaHaveTheSameKOfCreepingFlow) {
    const PoreSpace space = pore_space_of(boxes()[2].packing);
    const std::vector<double> reynolds;
    const InertialSeries series = lbm_inertial_flows(space, 0.12, reynolds, 1.0, {});
    ASSERT_TRUE(series.stretch);
    const double creeping = lbm_permeability(space, 0.12, {.grids = 1, .fields = FieldFiles::none}).fine().permeability_m2;
    EXPECT_NEAR(series.creeping_permeability_m2 / creeping, 1.0, 1e-3);  // the iteration tolerance
}

}  // namespace
}  // namespace porepack
