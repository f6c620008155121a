// Links between neighbouring pore cells that solid closes although the centres of both cells lie in pores: plates thinner than a
// voxel, the edges of grains, and in images the edge that two solid voxels share.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pore_space/cell_set.hpp"

namespace porepack::pore_space {

/// The closed links of a grid's cells to their neighbours across faces and edges. About four bytes per cell with such a link.
class LinkCuts {
public:
    /// The links of `cell` along the steps of `links`, see bit().
    struct Cut {
        std::size_t cell;
        std::uint32_t links;
    };
    LinkCuts() = default;
    /// In any order; the links of cells that occur several times are joined.
    LinkCuts(const geometry::Grid& grid, std::vector<Cut> cuts);

    /// Steps are -1, 0 or 1 along each axis.
    [[nodiscard]] static constexpr std::uint32_t bit(const std::array<int, 3>& step) {
        return std::uint32_t{1} << static_cast<unsigned>(13 + step[0] + 3 * step[1] + 9 * step[2]);
    }
    [[nodiscard]] bool empty() const { return links_.empty(); }
    [[nodiscard]] bool at(std::size_t cell) const { return !links_.empty() && cells_.contains(cell); }
    /// All closed links of the cell.
    [[nodiscard]] std::uint32_t links(std::size_t cell) const {
        return at(cell) ? links_[static_cast<std::size_t>(cells_.rank(cell))] : 0U;
    }
    [[nodiscard]] bool closed(std::size_t cell, const std::array<int, 3>& step) const { return (links(cell) & bit(step)) != 0; }
    /// Number of closed links, each counted from both of its ends.
    [[nodiscard]] std::int64_t count() const;

private:
    CellSet cells_;
    std::vector<std::uint32_t> links_;  // by member of cells_
};

}  // namespace porepack::pore_space
