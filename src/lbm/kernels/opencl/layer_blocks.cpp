#include "lbm/kernels/opencl/layer_blocks.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/parallel.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm::opencl {
namespace {

struct PartOfBatch {
    std::vector<std::uint32_t> order, first_in_block = {0}, layer_of_block, layer, block_of_layer = {0};
};

PartOfBatch part_of(const Domain& domain, const LayerBlocks::Batch& batch) {
    std::vector<std::size_t> cells(batch.nodes);
    domain.cells.list(batch.first_node, cells);
    std::vector<std::uint32_t> layer_of_node(batch.nodes), count(domain.layers());
    for (std::size_t i = 0; i < batch.nodes; ++i) ++count[layer_of_node[i] = static_cast<std::uint32_t>(domain.layer_of_cell(cells[i]))];
    PartOfBatch part;
    std::vector<std::uint32_t> next(count.size());  // place of a layer's next node
    for (std::uint32_t layer = 0, begin = 0; layer < count.size(); begin += count[layer++]) {
        next[layer] = begin;
        if (count[layer] == 0) continue;
        for (std::uint32_t at = begin; at < begin + count[layer]; at += LayerBlocks::block_nodes) {
            part.first_in_block.push_back(std::min<std::uint32_t>(at + LayerBlocks::block_nodes, begin + count[layer]));
            part.layer_of_block.push_back(layer);
        }
        part.layer.push_back(layer);
        part.block_of_layer.push_back(static_cast<std::uint32_t>(part.layer_of_block.size()));
    }
    if (domain.drive.axis == 2) return part;  // nodes are in the order of their cells
    part.order.resize(batch.nodes);
    for (std::uint32_t i = 0; i < batch.nodes; ++i) part.order[next[layer_of_node[i]]++] = i;
    return part;
}

}  // namespace

LayerBlocks::LayerBlocks(const Domain& domain) {
    for (std::size_t first = 0; first < domain.nodes(); first += batch_nodes)
        batches.push_back({.first_node = first, .nodes = std::min(batch_nodes, domain.nodes() - first)});
    std::vector<PartOfBatch> parts(batches.size());
    parallel_for(parts.size(), [&](std::size_t p) { parts[p] = part_of(domain, batches[p]); });
    const auto append = [](std::vector<std::uint32_t>& list, const std::vector<std::uint32_t>& more) {
        const std::uint64_t first = list.size();
        list.insert(list.end(), more.begin(), more.end());
        return first;
    };
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const PartOfBatch part = std::move(parts[p]);
        Batch& batch = batches[p];
        batch.blocks = part.layer_of_block.size();
        batch.layers = part.layer.size();
        batch.first_order = append(order, part.order);
        batch.first_in_block = append(first_in_block, part.first_in_block);
        batch.first_layer_of_block = append(layer_of_block, part.layer_of_block);
        batch.first_layer = append(layer, part.layer);
        batch.first_block_of_layer = append(block_of_layer, part.block_of_layer);
    }
}

}  // namespace porepack::lbm::opencl
