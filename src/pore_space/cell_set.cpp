#include "pore_space/cell_set.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace porepack::pore_space {

CellSet::CellSet(const geometry::Grid& grid) : words_((grid.size() + 63) / 64, 0) {}

CellSet::CellSet(const geometry::Grid& grid, std::vector<std::uint64_t> words) : words_(std::move(words)) {
    if (words_.size() != (grid.size() + 63) / 64) throw std::invalid_argument("the words are not of this grid");
    finish();
}

void CellSet::insert_run(std::size_t row_cell, int first, int last) {
    const std::size_t begin = row_cell + static_cast<std::size_t>(first), end = row_cell + static_cast<std::size_t>(last);
    const std::uint64_t from = ~std::uint64_t{0} << (begin % 64), to = ~std::uint64_t{0} >> (63 - end % 64);
    if (begin / 64 == end / 64) {
        words_[begin / 64] |= from & to;
        return;
    }
    words_[begin / 64] |= from;
    for (std::size_t w = begin / 64 + 1; w < end / 64; ++w) words_[w] = ~std::uint64_t{0};
    words_[end / 64] |= to;
}

void CellSet::finish() {
    first_of_block_.clear();
    first_of_block_.reserve(words_.size() / words_per_block + 2);
    size_ = 0;
    for (std::size_t w = 0; w < words_.size(); ++w) {
        if (w % words_per_block == 0) first_of_block_.push_back(size_);
        size_ += std::popcount(words_[w]);
    }
    first_of_block_.push_back(size_);
}

// The word that holds a member, and the number of members before this word.
std::size_t CellSet::word_of(std::size_t member, std::int64_t& before) const {
    const auto wanted = static_cast<std::int64_t>(member);
    const auto block = std::upper_bound(first_of_block_.begin(), first_of_block_.end() - 1, wanted) - first_of_block_.begin() - 1;
    before = first_of_block_[static_cast<std::size_t>(block)];
    std::size_t w = static_cast<std::size_t>(block) * words_per_block;
    for (int here = std::popcount(words_[w]); before + here <= wanted; here = std::popcount(words_[w])) {
        before += here;
        ++w;
    }
    return w;
}

void CellSet::list(std::size_t first, std::span<std::size_t> cells) const {
    if (cells.empty()) return;
    std::int64_t before = 0;
    std::size_t w = word_of(first, before);
    std::uint64_t rest = words_[w];
    for (auto skip = static_cast<std::int64_t>(first) - before; skip > 0; --skip) rest &= rest - 1;
    for (std::size_t& cell : cells) {
        while (rest == 0) rest = words_[++w];
        cell = 64 * w + static_cast<std::size_t>(std::countr_zero(rest));
        rest &= rest - 1;
    }
}

std::size_t CellSet::cell(std::size_t member) const {
    std::size_t found = 0;
    list(member, std::span(&found, 1));
    return found;
}

}  // namespace porepack::pore_space
