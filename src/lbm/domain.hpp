// The fluid nodes that flow can reach, and where each of their populations comes from.
#pragma once

#include <cstdint>
#include <vector>

#include "converters/percolation.hpp"

namespace porepack {

struct Domain {
    Grid grid;
    Drive drive;
    std::vector<std::int32_t> cell;  ///< cell of each node, in ascending order
    /// Where each population comes from: the slot that is read into slot s before the collision is pull[s]. Slots at and
    /// above populations() are the open ends' links.
    std::vector<std::uint32_t> pull;
    struct OpenLink {
        std::uint32_t source;  ///< slot of the outgoing population whose mirror image comes in
        double weight;
        bool inlet;
    };
    std::vector<OpenLink> open_links;
    std::int64_t isolated_cells = 0;  ///< pore cells that no flow reaches
    [[nodiscard]] std::size_t nodes() const { return cell.size(); }

    /// Nodes lie in blocks, and a block holds its 19 populations one after the other: one stream of memory to read, one to
    /// write. The last block is padded; padding reads itself.
    static constexpr std::size_t block = 64;
    [[nodiscard]] std::size_t blocks() const { return (nodes() + block - 1) / block; }
    [[nodiscard]] std::size_t populations() const { return 19 * block * blocks(); }
    [[nodiscard]] static std::size_t slot(std::size_t q, std::size_t node) { return (node / block * 19 + q) * block + node % block; }
};

/// Bytes that a run takes for a grid of `cells` with `fluid` of them as nodes, set-up included.
[[nodiscard]] double lbm_memory_bytes(double cells, double fluid);

/// Keeps the cells that flow can reach (find_percolating_cells); links of the lattice are kept between all kept cells.
[[nodiscard]] Domain build_domain(const PhaseImage& image, const Drive& drive);

}  // namespace porepack
