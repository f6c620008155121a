// The tortuosity factor with walls at their exact positions, against exact answers.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <tuple>
#include <utility>

#include "analysis/tortuosity.hpp"
#include "core/machine.hpp"
#include "support/helpers.hpp"
#include "support/turned_arrays.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack {
namespace {

// One grid at several resolutions, mean over positions on the grid: at most 1.3 % at 10 cells per diameter, order 2.
TEST(DiffusiveWalls, ASingleGridIsOfSecondOrder) {
    std::mt19937 random(77);
    for (const auto& [grain, f] :
         {std::pair(test::TurnedArray::Grain::rod, 0.2), std::pair(test::TurnedArray::Grain::rod, 0.6),
          std::pair(test::TurnedArray::Grain::simple_cubic, 0.343), std::pair(test::TurnedArray::Grain::body_centred, 0.45)}) {
        std::array<double, 3> errors{};
        for (std::size_t i = 0; i < 3; ++i) {
            const double cells = 10.0 * std::pow(1.6, i);
            for (int position = 0; position < 4; ++position) {
                const test::TurnedArray array{.grain = grain, .solid_fraction = f, .shift = test::random_shift(random)};
                errors[i] += (diffusive_on_grid(array.space(), array.diameter() / cells, Axis::x).value / array.exact(Axis::x) - 1.0) / 4.0;
            }
        }
        std::printf("  %s %.3f: errors %+.3f %+.3f %+.3f %%\n", grain == test::TurnedArray::Grain::rod ? "rods" : "spheres", f,
                    100 * errors[0], 100 * errors[1], 100 * errors[2]);
        EXPECT_LT(std::abs(errors[0]), 0.013);
        EXPECT_GT(std::log(std::abs(errors[0] / errors[2])) / std::log(2.56), 1.5);  // with the scatter between positions
    }
}

// Touching spheres, whose contacts are narrower than any cell. There is no exact series: the references are whole voxels on an eighth of
// the cell with 40, 80 and 160 of them per side, extrapolated (from the last two and from the first two: 5e-4 apart). Intervals are not
// asserted: they hold the error of smooth walls, and contacts are not smooth.
TEST(DiffusiveWalls, TouchingSpheresAreWithinTwoPerCentAtTenCells) {
    std::mt19937 random(31);
    for (const auto& [grain, f, reference] :
         {std::tuple(test::TurnedArray::Grain::simple_cubic, std::numbers::pi / 6.0, 1.3865),
          std::tuple(test::TurnedArray::Grain::body_centred, std::sqrt(3.0) * std::numbers::pi / 8.0, 1.4763)}) {
        for (int position = 0; position < 3; ++position) {
            const test::TurnedArray array{.grain = grain, .solid_fraction = f, .shift = test::random_shift(random)};
            const double single = diffusive_on_grid(array.space(), array.diameter() / 10, Axis::x).value / reference - 1.0;
            const double three = diffusive_tortuosity(array.space(), array.diameter() / 10, Axis::x).value() / reference - 1.0;
            std::printf("  %.3f: one grid %+.2f %%, three grids %+.2f %%\n", f, 100 * single, 100 * three);
            EXPECT_LT(std::abs(single), 0.02);
            EXPECT_LT(std::abs(three), 0.02);
        }
    }
}

// Three grids, the finest of 9 to 12 cells per diameter, at odd angles and random positions: within 0.5 %, and in the interval.
TEST(DiffusiveWalls, IntervalsHoldOnTurnedArrays) {
    std::mt19937 random(4242);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    int held = 0;
    constexpr int count = 40;
    double worst = 0.0, errors = 0.0, widths = 0.0;
    for (int trial = 0; trial < count; ++trial) {
        const auto grain = static_cast<test::TurnedArray::Grain>(trial % 3);
        const auto turn = trial % 10 == 0   ? test::TurnedArray::Turn::about_z
                          : trial % 10 == 5 ? test::TurnedArray::Turn::about_odd_axis
                                            : test::TurnedArray::Turn::none;
        const test::TurnedArray array = test::random_array(grain, turn, random);
        const auto axis = static_cast<Axis>(trial / 3 % 3);
        const DiffusiveEstimate found = diffusive_tortuosity(array.space(), array.diameter() / (9.0 + 3.0 * unit(random)), axis);
        ASSERT_TRUE(found.interval()) << found.no_limit_because;
        const double exact = array.exact(axis), error = found.value() / exact - 1.0;
        held += found.interval()->low <= exact && exact <= found.interval()->high ? 1 : 0;
        worst = std::max(worst, std::abs(error));
        errors += std::abs(error) / count;
        widths += 0.5 * (found.interval()->high - found.interval()->low) / exact / count;
        EXPECT_GE(found.value(), 1.0);
    }
    std::printf("  %d of %d held, error at most %.2f %%, mean %.3f %%, half width %.3f %%\n", held, count, 100 * worst, 100 * errors,
                100 * widths);
    EXPECT_GE(held, 35);  // 38 are expected; fewer than 35 have a probability of 2 %
    EXPECT_LT(worst, 0.005);
}

// The same array from a section that cuts the spheres: in situ the array's value; between planes of given concentration too low.
TEST(DiffusiveWalls, ASectionInSituIsThatOfTheArray) {
    const double f = 0.343, exact = (1.0 - f) / test::among_spheres(f, false);
    Packing packing{.container = vessels::make_box({1.0, 1.0, 7.0}, {true, true, false}),
                    .shapes = {make_preset(ShapeKind::sphere, std::cbrt(6.0 * f / std::numbers::pi), 0.0)},
                    .bodies = {}};
    for (int layer = 0; layer < 7; ++layer) packing.bodies.push_back({.shape = 0, .position_m = {0.5, 0.5, layer + 0.5}});
    const PoreSpace bed = pore_space_of(packing).with_section({2.27, 4.27});
    const double in_situ = diffusive_tortuosity(bed.with_ends(Ends::in_situ, 1.5), 1.0 / 20, Axis::z).value();
    const double planes = diffusive_tortuosity(bed.with_ends(Ends::planes), 1.0 / 20, Axis::z).value();
    std::printf("  exact %.4f, in situ %.4f, planes %.4f\n", exact, in_situ, planes);
    EXPECT_NEAR(in_situ / exact, 1.0, 0.002);
    EXPECT_LT(planes / exact, 0.998);
}

// Straight pores have exactly 1, whatever the grid does to them.
TEST(DiffusiveWalls, NeverBelowOne) {
    std::mt19937 random(5);
    for (const double f : {0.1, 0.5, 0.7}) {
        const test::TurnedArray array{.solid_fraction = f, .shift = test::random_shift(random)};
        const DiffusiveEstimate found = diffusive_tortuosity(array.space(), array.diameter() / 9.3, Axis::z);
        EXPECT_GE(found.value(), 1.0);
        EXPECT_NEAR(found.value(), 1.0, 2e-3);  // of the porosity
        EXPECT_EQ(found.interval()->low, 1.0);
    }
}

// (3 - eps)/2 is the least of isotropic packings: pores along rods are below it, those across rods and between spheres are not.
TEST(DiffusiveWalls, AValueBelowTheIsotropicLimitCarriesANote) {
    const auto note_of = [](const test::TurnedArray& array, Axis direction) {
        return compute_diffusive_tortuosity(array.space(), {.voxel_size_m = array.diameter() / 10.0}, direction).note.value_or("");
    };
    const test::TurnedArray rods{.solid_fraction = 0.3}, spheres{.grain = test::TurnedArray::Grain::simple_cubic, .solid_fraction = 0.3};
    EXPECT_TRUE(test::has(note_of(rods, Axis::z), "below (3 - porosity)/2 = 1.15"));
    EXPECT_EQ(note_of(rods, Axis::x), "");
    EXPECT_EQ(note_of(spheres, Axis::z), "");
}

TEST(DiffusiveWalls, TheNumberOfThreadsChangesNoBit) {
    const test::TurnedArray array{.grain = test::TurnedArray::Grain::body_centred,
                                  .turn = test::TurnedArray::Turn::about_odd_axis,
                                  .solid_fraction = 0.4,
                                  .shift = {0.1, 0.2, 0.3}};
    const PoreSpace space = array.space();
    const int threads = thread_count();
    set_thread_count(1);
    const double one = diffusive_on_grid(space, array.diameter() / 8, Axis::y).value;
    set_thread_count(2);
    EXPECT_EQ(diffusive_on_grid(space, array.diameter() / 8, Axis::y).value, one);
    set_thread_count(threads);
}

}  // namespace
}  // namespace porepack
