// The wall links as the fast kernel takes them: three bytes each.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lbm/addresses.hpp"
#include "lbm/lattice.hpp"

namespace porepack {

/// The wall links of all chunks, in the order of chunk and direction; those in gaps of one node apart, in pairs.
struct ChunkedWalls {
    std::vector<std::uint64_t> first;                                // by chunk
    std::vector<std::array<std::uint8_t, d3q19::directions>> count;  // by chunk and direction
    std::vector<std::uint8_t> place;                                 // in the chunk
    std::vector<std::uint16_t> distance;
    struct Gap {
        std::uint8_t place, q;  // q is odd
        std::uint16_t distance, opposite_distance;
    };
    std::vector<std::uint64_t> first_gap;
    std::vector<Gap> gaps;

    explicit ChunkedWalls(const Domain& domain);
    [[nodiscard]] double bytes() const;
};

}  // namespace porepack
