// In-place streaming ("AA pattern", Bailey et al. 2009): where the populations of each node are before every second step.
#pragma once

#include <cstdint>
#include <vector>

#include "lbm/domain.hpp"

namespace porepack::lbm::cpu {

/// Population q that arrives at a node is, before an even step, in the node's own slot q; before an odd step in the slot
/// given here: its neighbour's slot opposite(q), or its own slot q at a wall. A step writes the population leaving along
/// opposite(q) to the slot from which it read q, so only one node uses each slot. Nodes are stored in chunks, and a chunk
/// holds its 19 populations one after the other: an even step reads memory sequentially.
/// For an odd step the slots of one q are read one vector at a time: neighbours in a row of cells are adjacent, so that a
/// vector mostly comes from one or two locations in memory. SIMD lanes from a third location are read one by one.
struct Addresses {
    struct Vector {
        std::uint32_t first, second;              ///< lane i is in slot first + i ...
        std::uint16_t first_lanes, second_lanes;  ///< ... if bit i is set here
    };
    struct Single {
        std::uint32_t slot;
        std::uint16_t place;  ///< chunk_nodes q + node in the chunk
    };
    std::size_t slots = 0;
    std::vector<Vector> vectors;  ///< by chunk, q = 1, 2, ... 18, and SIMD lanes
    std::vector<Single> singles;  ///< by chunk
    std::vector<std::uint32_t> first_single;
    [[nodiscard]] double bytes() const {
        return static_cast<double>(vectors.size() * sizeof(Vector) + singles.size() * sizeof(Single) + first_single.size() * 4);
    }
};

inline constexpr std::size_t chunk_nodes = 128;
[[nodiscard]] constexpr std::size_t slot_of(std::size_t q, std::size_t node) {
    return (node / chunk_nodes * 19 + q) * chunk_nodes + node % chunk_nodes;
}

[[nodiscard]] Addresses find_addresses(const Domain& domain, std::size_t lanes);

}  // namespace porepack::lbm::cpu
