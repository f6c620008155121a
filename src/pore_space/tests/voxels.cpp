// Voxels of grains, and sets of cells.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "pore_space/cell_set.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/voxels.hpp"
#include "support/basics.hpp"
#include "vessels/config.hpp"

namespace porepack {
using namespace packing;
using namespace vessels;
using namespace pore_space;
namespace {

using test::has;
using test::message_of;

// A section whose buffer ends at the floor: whole voxels may begin half a voxel below it, and rounding must not matter.
TEST(Voxels, MayBeginHalfAVoxelBelowTheFloor) {
    const Container container = parse_container("box:0.03,0.03,0.1");
    geometry::Grid grid{.cells = {30, 30, 60}, .origin_m = {0.0, 0.0, 0.0}, .spacing_m = {1e-3, 1e-3, 1e-3}};
    const auto check = [&](double bottom_m) {
        grid.origin_m[2] = bottom_m;
        pore_space::require_fit(grid, container, {0.02, 0.04}, "here", false);
    };
    EXPECT_NO_THROW(check(std::nextafter(-0.5e-3, -1.0)));
    EXPECT_TRUE(has(message_of<core::UserError>([&] { check(-2e-3); }), "the image reaches from -0.002 to 0.058 m"));
}

TEST(Voxels, RefusesWhatCannotBe) {
    const Container box = parse_container("box:1,1,1:periodic");
    EXPECT_TRUE(has(message_of<UserError>([&] {
                        (void)plan_voxels(parse_container("box:1,0.73,1:periodic"), {0, 1}, 0.7, {}, 1.0);
                    }),
                    "no whole numbers of voxels of about 0.7 m"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)plan_voxels(box, {0, 1}, 0.5, {}, 0.3); }), "larger than the grain"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)plan_voxels(box, {0, 1}, 1e-5, {}, 1.0); }), "cells"));
    EXPECT_EQ(plan_voxels(parse_container("cylinder:0.05,0.2"), {0.02, 0.06}, 3e-4, {}, 1.0).grid.cells[2], 133);
}

TEST(Voxels, NarrowGapsAreThoseBetweenSolids) {
    // Along x: solid, a gap of two, solid, a gap of three, solid; open only at its ends along y and z.
    PhaseImage image{.grid = {.cells = {8, 3, 3}}, .phase = std::vector<std::uint8_t>(72, Phase::pore), .notes = {}};
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j)
            for (const int i : {0, 3, 7}) image.phase[image.grid.index(i, j, k)] = Phase::grain;
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 1), 0.0);
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 2), 2.0 / 5.0);
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 3), 1.0);
    std::fill(image.phase.begin(), image.phase.end(), Phase::grain);
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 3), 0.0);
}

TEST(CellSet, NumbersItsCells) {
    const Grid grid{.cells = {37, 11, 9}};
    CellSet set(grid);
    std::vector<std::size_t> expected;
    std::mt19937 random(5);
    for (int k = 0; k < 9; ++k)
        for (int j = 0; j < 11; ++j) {
            const std::size_t row = grid.index(0, j, k);
            for (int first = static_cast<int>(random() % 9); first < 37; first += 3 + static_cast<int>(random() % 12)) {
                const int last = std::min<int>(36, first + static_cast<int>(random() % 30));
                set.insert_run(row, first, last);
                for (int i = first; i <= last; ++i) expected.push_back(row + static_cast<std::size_t>(i));
                first = last + 1;
            }
        }
    set.insert_run(grid.index(0, 10, 8), 0, 36);  // words may be filled to their last bit
    for (int i = 0; i < 37; ++i) expected.push_back(grid.index(i, 10, 8));
    std::sort(expected.begin(), expected.end());
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    set.finish();
    ASSERT_EQ(set.size(), static_cast<std::int64_t>(expected.size()));
    std::vector<std::size_t> listed;
    set.for_each([&](std::size_t cell) { listed.push_back(cell); });
    EXPECT_EQ(listed, expected);
    for (std::size_t member = 0; member < expected.size(); ++member) {
        ASSERT_EQ(set.cell(member), expected[member]);
        ASSERT_EQ(set.find(expected[member]), static_cast<std::int64_t>(member));
    }
    for (std::size_t first = 0; first < expected.size(); first += 128) {
        std::vector<std::size_t> part(std::min<std::size_t>(128, expected.size() - first));
        set.list(first, part);
        ASSERT_TRUE(std::equal(part.begin(), part.end(), expected.begin() + static_cast<std::ptrdiff_t>(first)));
    }
    std::size_t missing = 0;
    for (std::size_t cell = 0; cell < grid.size(); ++cell)
        if (set.find(cell) < 0) ++missing;
    EXPECT_EQ(missing, grid.size() - expected.size());
}

}  // namespace
}  // namespace porepack
