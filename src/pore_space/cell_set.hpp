// A set of cells of a grid, one bit per cell, with the number of each cell in the set.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/grid.hpp"

namespace porepack::pore_space {

/// Cells of a grid in ascending order; the members are numbered 0, 1, 2, ... 64-bit counts; 0.14 bytes per cell of the grid.
/// Filled by insert_row() for all rows, then finish().
class CellSet {
public:
    CellSet() = default;
    explicit CellSet(const geometry::Grid& grid);
    /// From the words() of another set of the same grid; finished.
    CellSet(const geometry::Grid& grid, std::vector<std::uint64_t> words);

    /// Adds the cells x = first .. last of the row of cells along x that begins at `row_cell`. Different rows share words: one thread.
    void insert_run(std::size_t row_cell, int first, int last);
    /// Counts the members; call it once, after all have been inserted.
    void finish();

    [[nodiscard]] std::int64_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    /// Of a grid, not only declared.
    [[nodiscard]] bool has_grid() const { return !words_.empty(); }
    [[nodiscard]] bool contains(std::size_t cell) const { return (words_[cell / 64] >> (cell % 64) & 1U) != 0; }
    /// Number of members below `cell`: the number of `cell` itself if it is a member.
    [[nodiscard]] std::int64_t rank(std::size_t cell) const {
        std::size_t word = cell / 64;
        const std::size_t block = word / words_per_block;
        std::int64_t count = first_of_block_[block];
        for (std::size_t w = block * words_per_block; w < word; ++w) count += std::popcount(words_[w]);
        const std::uint64_t below = (std::uint64_t{1} << (cell % 64)) - 1;
        return count + std::popcount(words_[word] & below);
    }
    /// Number of the cell in the set, or -1.
    [[nodiscard]] std::int64_t find(std::size_t cell) const { return contains(cell) ? rank(cell) : -1; }
    /// Cells of the members number first, first + 1, ...; as many as `cells` holds.
    void list(std::size_t first, std::span<std::size_t> cells) const;
    [[nodiscard]] std::size_t cell(std::size_t member) const;
    /// visit(cell) for all members, ascending.
    template <typename Visit>
    void for_each(const Visit& visit) const {
        for (std::size_t w = 0; w < words_.size(); ++w)
            for (std::uint64_t rest = words_[w]; rest != 0; rest &= rest - 1)
                visit(64 * w + static_cast<std::size_t>(std::countr_zero(rest)));
    }
    /// 64 cells from 64 word on, cell 64 word in the lowest bit.
    [[nodiscard]] std::uint64_t word(std::size_t word) const { return words_[word]; }
    [[nodiscard]] std::span<const std::uint64_t> words() const { return words_; }

private:
    static constexpr std::size_t words_per_block = 8;
    [[nodiscard]] std::size_t word_of(std::size_t member, std::int64_t& before) const;

    std::vector<std::uint64_t> words_;
    std::vector<std::int64_t> first_of_block_;  ///< number of members before each block, and of all
    std::int64_t size_ = 0;
};

}  // namespace porepack::pore_space
