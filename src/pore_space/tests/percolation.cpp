// Pores that are blocked, isolated, or wind.
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/voxels.hpp"
#include "support/basics.hpp"

namespace porepack {
using namespace core;
using namespace geometry;
using namespace pore_space;
namespace {

using test::has;
using test::message_of;

TEST(Percolation, FindsBlockedAndIsolatedPores) {
    PhaseImage image{.grid = {.cells = {5, 5, 6}}, .phase = std::vector<std::uint8_t>(150, Phase::grain), .notes = {}};
    const Drive drive{.axis = 2, .periodic = {false, false, false}};
    for (int k = 0; k < 6; ++k) image.phase[image.grid.index(1, 1, k)] = Phase::pore;
    image.phase[image.grid.index(3, 3, 3)] = Phase::pore;
    const Percolation open = find_percolating_cells(image, drive);
    EXPECT_EQ(open.isolated_cells, 1);
    EXPECT_EQ(open.cells.size(), 6);
    image.phase[image.grid.index(1, 1, 2)] = Phase::grain;
    EXPECT_TRUE(has(message_of<NumericalError>([&] { (void)find_percolating_cells(image, drive); }), "does not percolate"));
    // In a periodic box: a channel that returns to itself without passing round the box carries no flow.
    const Drive periodic{.axis = 2, .periodic = {true, true, true}};
    EXPECT_TRUE(has(message_of<NumericalError>([&] { (void)find_percolating_cells(image, periodic); }), "does not percolate"));
    image.phase[image.grid.index(1, 1, 2)] = Phase::pore;
    EXPECT_EQ(find_percolating_cells(image, periodic).isolated_cells, 1);
}

TEST(Percolation, AChannelThatTurnsBackThroughAFaceDoesNotWind) {
    // Up through the top face and down again beside it: two turns that cancel. With one more connection it winds round.
    PhaseImage image{.grid = {.cells = {6, 4, 6}}, .phase = std::vector<std::uint8_t>(144, Phase::grain), .notes = {}};
    const auto open = [&](int i, int j, int k) { image.phase[image.grid.index(i, j, k)] = Phase::pore; };
    for (const int k : {0, 1, 4, 5})
        for (const int i : {1, 3}) open(i, 1, k);
    open(2, 1, 1);
    open(2, 1, 4);
    const Drive periodic{.axis = 2, .periodic = {true, true, true}};
    EXPECT_THROW((void)find_percolating_cells(image, periodic), DoesNotPercolate);
    for (const int k : {2, 3}) open(3, 1, k);
    EXPECT_EQ(find_percolating_cells(image, periodic).cells.size(), 12);
    // The same along x and y, and between end planes.
    for (const int axis : {0, 1, 2}) {
        PhaseImage bar{.grid = {.cells = {4, 4, 4}}, .phase = std::vector<std::uint8_t>(64, Phase::grain), .notes = {}};
        for (int at = 0; at < 4; ++at) {
            std::array<int, 3> place = {2, 2, 2};
            place[static_cast<std::size_t>(axis)] = at;
            bar.phase[bar.grid.index(place[0], place[1], place[2])] = Phase::pore;
        }
        for (const int along : {0, 1, 2}) {
            const Drive drive{.axis = along, .periodic = {true, true, true}};
            if (along == axis)
                EXPECT_EQ(find_percolating_cells(bar, drive).cells.size(), 4);
            else
                EXPECT_THROW((void)find_percolating_cells(bar, drive), DoesNotPercolate);
        }
    }
}

}  // namespace
}  // namespace porepack
