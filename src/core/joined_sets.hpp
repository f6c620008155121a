// Elements that are joined step by step, and the set to which each belongs (union-find with path halving).
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace porepack::inline core {

class JoinedSets {
public:
    /// Each of the `count` elements alone.
    explicit JoinedSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    /// One element of the set, the same for all of its elements.
    [[nodiscard]] std::size_t root(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// The root of b is then that of both.
    void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }

private:
    std::vector<std::size_t> parent_;
};

}  // namespace porepack::inline core
