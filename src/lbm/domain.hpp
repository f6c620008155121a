// The fluid nodes that flow can reach, and where each of their populations comes from.
#pragma once

#include <cstdint>
#include <vector>

#include "converters/percolation.hpp"

namespace porepack {

struct Domain {
    Grid grid;
    Drive drive;
    std::vector<std::int32_t> cell;   ///< cell of each node, in ascending order
    /// Slot of population q of node n before the collision: pull[q * nodes + n]. Slots below 19 * nodes are populations
    /// (q' * nodes + n'), slots above are the open ends' links.
    std::vector<std::uint32_t> pull;
    struct OpenLink {
        std::uint32_t source;  ///< slot of the outgoing population (opposite direction, same node)
        double weight;
        bool inlet;
    };
    std::vector<OpenLink> open_links;
    std::int64_t isolated_cells = 0;  ///< pore cells that no flow reaches
    [[nodiscard]] std::size_t nodes() const { return cell.size(); }
};

/// Bytes that a run takes for a grid of `cells` with `fluid` of them as nodes, set-up included.
[[nodiscard]] double lbm_memory_bytes(double cells, double fluid);

/// Keeps the cells that flow can reach (find_percolating_cells); links of the lattice are kept between all kept cells.
[[nodiscard]] Domain build_domain(const PhaseImage& image, const Drive& drive);

}  // namespace porepack
