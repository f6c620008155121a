// In-place streaming ("AA pattern", Bailey et al. 2009): where the populations of each node are before every second step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lbm/domain.hpp"

namespace porepack::lbm::layout {

inline constexpr std::size_t chunk_nodes = 128, group_nodes = 16;
[[nodiscard]] constexpr std::size_t slot_of(std::size_t q, std::size_t node) {
    return (node / chunk_nodes * 19 + q) * chunk_nodes + node % chunk_nodes;
}

[[nodiscard]] constexpr std::size_t chunks_for(std::size_t nodes) {
    return (nodes + chunk_nodes - 1) / chunk_nodes;
}

/// The populations that two slabs share, in the same order in both.
struct SharedSlots {
    std::vector<std::uint64_t> own;     ///< of this slab's nodes: those that nodes beyond read and write in odd steps
    std::vector<std::uint64_t> beyond;  ///< of the nodes beyond, behind this slab's chunks: those that its own nodes read and write
};

/// From where the slots of a chunk's groups are counted: 2^31 slots below its own, or 0.
[[nodiscard]] constexpr std::size_t base_of(std::size_t chunk) {
    constexpr std::size_t reach = std::size_t{1} << 31U;
    const std::size_t own = slot_of(0, chunk * chunk_nodes);
    return own > reach ? own - reach : 0;
}

/// Population q that arrives at a node is, before an even step, in the node's own slot q; before an odd step in the slot
/// given here: its neighbour's slot opposite(q), or its own slot q at a wall. A step writes the population leaving along
/// opposite(q) to the slot from which it read q, so only one node uses each slot. Nodes are stored in chunks, and a chunk
/// holds its 19 populations one after the other: an even step reads memory sequentially.
/// For an odd step the slots of one q are read in groups of 16 nodes: neighbours in a row of cells are adjacent, so that besides its own
/// slots a group mostly comes from one or two locations in memory. Nodes of a third location are read one by one, and so are those that
/// are 2^31 slots away from their chunk (through a periodic face of a large grid).
/// Nodes of other slabs have chunks behind the slab's own, in which only shared slots are used.
struct Addresses {
    /// Node i of a group is in slot base_of(chunk) + first + i if bit i is set in `first_nodes` alone, the same with `second`; in its own
    /// slot (a wall) if it is set in neither; and single if it is set in both.
    struct Group {
        std::uint32_t first, second;
        std::uint16_t first_nodes, second_nodes;
    };
    /// 12 bits: chunk_nodes q + node in the chunk; above: the slot.
    using Single = std::uint64_t;
    static constexpr int place_bits = 12;
    std::size_t slots = 0;              ///< with those of other slabs' nodes
    std::array<SharedSlots, 2> shared;  ///< with the slabs below and above
    std::vector<Group> groups;          ///< by chunk, q = 1, 2, ... 18, and nodes of the chunk
    std::vector<Single> singles;        ///< by chunk
    std::vector<std::uint64_t> first_single;
    [[nodiscard]] double bytes() const {
        return static_cast<double>(groups.size() * sizeof(Group) + (singles.size() + first_single.size()) * 8);
    }
};

/// The groups of one chunk and q whose populations come from `slots` (of as many nodes as the chunk has). Nodes that no group holds are
/// added to `singles`.
void make_groups(std::span<const std::uint64_t> slots, std::size_t chunk, std::size_t q, Addresses::Group* groups,
                 std::vector<Addresses::Single>& singles);

[[nodiscard]] Addresses find_addresses(const Domain& domain);

}  // namespace porepack::lbm::layout
