// The nodes of a domain in blocks that lie in one layer normal to the flow, so that a device can sum over layers in an order of its own
// that is always the same.
#pragma once

#include <cstdint>
#include <vector>

#include "lbm/domain.hpp"

namespace porepack::lbm::opencl {

struct LayerBlocks {
    static constexpr std::size_t batch_nodes = 4096 * 128, block_nodes = 4096;

    /// Consecutive nodes, in whole chunks, for which a device has memory at once.
    struct Batch {
        std::size_t first_node, nodes;
        std::uint64_t first_order = 0;                 ///< in `order`
        std::uint64_t first_in_block = 0, blocks = 0;  ///< in first_in_block: one number more than blocks
        std::uint64_t first_layer_of_block = 0;        ///< in layer_of_block
        std::uint64_t first_layer = 0, layers = 0;     ///< in `layer`: the layers that it has nodes in
        std::uint64_t first_block_of_layer = 0;        ///< in block_of_layer: one number more than layers
    };
    std::vector<Batch> batches;
    std::vector<std::uint32_t> order;           ///< by batch: its nodes, sorted by layer; empty where they are so already
    std::vector<std::uint32_t> first_in_block;  ///< by batch: where blocks begin and end in that order
    std::vector<std::uint32_t> layer_of_block;
    std::vector<std::uint32_t> layer, block_of_layer;

    explicit LayerBlocks(const Domain& domain);
    [[nodiscard]] bool ordered() const { return !order.empty(); }
    [[nodiscard]] double bytes() const {
        return 4.0 *
               static_cast<double>(order.size() + first_in_block.size() + layer_of_block.size() + layer.size() + block_of_layer.size());
    }
};

}  // namespace porepack::lbm::opencl
