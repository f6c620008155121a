// What a prediction says of the slabs is what the parts get.
#include "lbm/slabs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "lbm/permeability.hpp"
#include "support/arrays.hpp"

namespace porepack {
namespace {

TEST(SlabShares, AreThoseThatThePartsGet) {
    // Grains in the lower part only, so that equal numbers of pore cells are slabs of unequal heights.
    Packing bed = test::random_bed("cylinder:1,3", 120, 0.12);
    bed.overlap_allowed = true;
    std::erase_if(bed.bodies, [](const packing::Body& body) { return body.position_m.z() > 1.2; });
    bed.bodies.push_back(bed.bodies.front());
    bed.bodies.back().position_m.z() = 2.8;  // the section reaches up to here
    const pore_space::PoreSpace space = pore_space::pore_space_of(bed);
    const geometry::Grid grid = space.plan_at(0.03).grid;
    const auto shares = lbm::slab_shares(space, grid, 3);
    std::array<double, 3> pores{};
    std::array<int, 3> layers{};
    core::run_parts(3, [&](const core::Communicator& parts) {
        const geometry::Grid slab = lbm::SlabCuts(space, grid, parts).slab_of(grid, false, parts).without_halo();
        const auto phases = space.phases_on(slab).phase;
        const auto part = static_cast<std::size_t>(parts.part());
        layers[part] = slab.cells[2];
        pores[part] = static_cast<double>(std::ranges::count(phases, geometry::Phase::pore));
    });
    const double total = pores[0] + pores[1] + pores[2];
    double sum = 0.0;
    for (std::size_t part = 0; part < 3; ++part) {
        EXPECT_NEAR(shares[part].height * grid.cells[2], layers[part], 1.0);
        EXPECT_NEAR(shares[part].pores, pores[part] / total, 0.03);
        sum += shares[part].pores;
    }
    EXPECT_NEAR(sum, 1.0, 1e-9);
    EXPECT_GT(layers[0], layers[2] + 3);
    const double largest = lbm::largest_slab(space, 0.03, {.grids = 1}, 3);
    EXPECT_NEAR(largest, (*std::ranges::max_element(layers) + 2.0) / grid.cells[2], 0.03);
    EXPECT_EQ(lbm::largest_slab(space, 0.03, {.grids = 1}, 1), 1.0);
}

}  // namespace
}  // namespace porepack
