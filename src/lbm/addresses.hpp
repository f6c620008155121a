// In-place streaming ("AA pattern", Bailey et al. 2009): where the populations of each node lie before every second step.
#pragma once

#include <cstdint>
#include <vector>

#include "lbm/domain.hpp"

namespace porepack {

/// Population q that arrives at a node lies, before an even step, in the node's own slot q; before an odd step in the slot
/// given here: its neighbour's slot opposite(q), or its own slot q where a wall is. A step writes what leaves along
/// opposite(q) where it read what came along q, so that each slot is touched by one node only. Nodes lie in chunks, and a chunk
/// holds its 19 populations one after the other: an even step is one stream of memory. The slots of one q that a chunk
/// needs in an odd step come in segments that lie one after the other in memory.
struct Addresses {
    std::size_t slots = 0;
    std::vector<std::uint64_t> first_segment;  ///< by chunk, and the end of the last; the segments of q = 1, 2, ... 18
    std::vector<std::uint32_t> slot;           ///< of each segment
    std::vector<std::uint8_t> length;
    [[nodiscard]] double bytes() const { return 8.0 * static_cast<double>(first_segment.size()) + 5.0 * static_cast<double>(slot.size()); }
};

inline constexpr std::size_t chunk_nodes = 128;
[[nodiscard]] constexpr std::size_t slot_of(std::size_t q, std::size_t node) {
    return (node / chunk_nodes * 19 + q) * chunk_nodes + node % chunk_nodes;
}

[[nodiscard]] Addresses find_addresses(const Domain& domain);

}  // namespace porepack
