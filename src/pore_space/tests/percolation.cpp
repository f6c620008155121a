// Pores that are blocked, isolated, or wind.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "core/communicator.hpp"
#include "core/error.hpp"
#include "pore_space/find_cuts.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/voxels.hpp"
#include "support/basics.hpp"

namespace porepack {
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

// The percolating cells of a slab, in the numbers of the whole grid, with those beyond its faces.
struct SlabCells {
    std::vector<std::size_t> own, below, above;
    std::int64_t isolated_cells = 0;
};
SlabCells percolating(const PhaseImage& whole, int first, int end, const Drive& drive, const Communicator& slabs) {
    PhaseImage image{.grid = whole.grid.slab_of(first, end, drive.periodic[2]), .phase = {}, .notes = {}};
    const std::size_t plane = whole.grid.index(0, 0, 1);
    const auto of_layer = [&](int layer) { return static_cast<std::size_t>(layer) * plane; };
    for (int k = 0; k < image.grid.cells[2]; ++k)
        for (std::size_t cell = 0; cell < plane; ++cell) image.phase.push_back(whole.phase[of_layer(image.grid.layer(k)) + cell]);
    const Percolation found = find_percolating_cells(image, drive, find_cuts(image, drive), slabs);
    SlabCells cells{.isolated_cells = found.isolated_cells};
    found.cells.for_each([&](std::size_t cell) { cells.own.push_back(of_layer(first) + cell); });
    const int layers = whole.grid.cells[2];
    if (found.beyond[0].has_grid())
        found.beyond[0].for_each([&](std::size_t cell) { cells.below.push_back(of_layer((first + layers - 1) % layers) + cell); });
    if (found.beyond[1].has_grid())
        found.beyond[1].for_each([&](std::size_t cell) { cells.above.push_back(of_layer(end % layers) + cell); });
    return cells;
}

// Near the threshold, where pieces wind through many slabs and round the box.
TEST(Percolation, OfSlabsIsThatOfTheWholeGrid) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto up_to = [&](int end) { return static_cast<int>(unit(random) * end); };
    int open = 0, closed = 0;
    for (int trial = 0; trial < 600; ++trial) {
        PhaseImage image{.grid = {.cells = {3 + up_to(6), 3 + up_to(6), 2 + up_to(8)}}, .phase = {}, .notes = {}};
        const double share = 0.25 + 0.35 * unit(random);
        for (std::size_t cell = 0; cell < image.grid.size(); ++cell)
            image.phase.push_back(unit(random) < share ? Phase::pore : Phase::grain);
        Drive drive{.axis = up_to(3), .periodic = {up_to(2) == 0, up_to(2) == 0, up_to(2) == 0}};
        if (drive.axis != 2) drive.periodic[static_cast<std::size_t>(drive.axis)] = true;
        std::vector<int> ends = {0};
        while (ends.back() < image.grid.cells[2])
            ends.push_back(std::min(image.grid.cells[2], ends.back() + 1 + up_to(image.grid.cells[2] - 1)));
        const int slabs = static_cast<int>(ends.size()) - 1;
        std::optional<SlabCells> whole;
        try {
            whole = percolating(image, 0, image.grid.cells[2], drive, no_communicator());
            ++open;
        } catch (const DoesNotPercolate&) {
            ++closed;
        }
        if (slabs == 1) continue;
        std::vector<SlabCells> parts(static_cast<std::size_t>(slabs));
        const auto divide = [&] {
            run_parts(slabs, [&](const Communicator& communicator) {
                const auto part = static_cast<std::size_t>(communicator.part());
                parts[part] = percolating(image, ends[part], ends[part + 1], drive, communicator);
            });
        };
        if (!whole) {
            EXPECT_THROW(divide(), DoesNotPercolate) << trial;
            continue;
        }
        divide();
        std::vector<std::size_t> all;
        for (std::size_t part = 0; part < parts.size(); ++part) {
            EXPECT_EQ(parts[part].isolated_cells, whole->isolated_cells) << trial;
            all.insert(all.end(), parts[part].own.begin(), parts[part].own.end());
            for (const std::vector<std::size_t>* beyond : {&parts[part].below, &parts[part].above})
                EXPECT_TRUE(std::includes(whole->own.begin(), whole->own.end(), beyond->begin(), beyond->end())) << trial;
        }
        EXPECT_EQ(all, whole->own) << trial << ", slabs: " << slabs;
    }
    EXPECT_GT(open, 100);
    EXPECT_GT(closed, 100);
}

}  // namespace
}  // namespace porepack
