// The wall links in the layout of the fast kernel: four bytes each.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lbm/kernels/layout/addresses.hpp"
#include "lbm/lattice.hpp"

namespace porepack::lbm::layout {

/// The wall links of all chunks; those in gaps of one node are stored separately, in pairs.
struct ChunkedWalls {
    std::vector<std::uint64_t> first;     // by chunk
    std::vector<std::uint16_t> row;       // chunk_nodes q + place in the chunk
    std::vector<std::uint16_t> distance;  // of the same link; longer by one vector than the number of links
    struct Gap {
        std::uint8_t place, q;  // q is odd
        std::uint16_t distance, opposite_distance;
    };
    std::vector<std::uint64_t> first_gap;
    std::vector<Gap> gaps;

    explicit ChunkedWalls(const Domain& domain);
    [[nodiscard]] double bytes() const;
};

}  // namespace porepack::lbm::layout
