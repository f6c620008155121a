// The nodes at the ends of a node's links.
#pragma once

#include <array>

#include "lbm/domain.hpp"
#include "lbm/lattice.hpp"

namespace porepack::lbm {

/// Looks neighbours up along rows of cells: fast when the nodes are requested in ascending order. For one thread.
class Neighbours {
public:
    explicit Neighbours(const Domain& domain);

    /// By direction q: the node at the end of the link, through periodic faces too, or -1 if there is none.
    [[nodiscard]] const std::array<std::int64_t, d3q19::directions>& of(std::size_t node);

private:
    void enter_row(std::size_t row, int x);

    struct Row {
        std::int64_t next = 0, end = 0;  // of its nodes
        std::int32_t first_cell = 0;
        bool exists = false;
        std::array<int, 3> q{};  // to x - 1, x, x + 1; -1 where the lattice has none
    };
    const Domain& domain_;
    std::size_t row_ = static_cast<std::size_t>(-1);
    std::array<Row, 9> rows_;
    std::array<std::int64_t, d3q19::directions> found_{};
};

}  // namespace porepack::lbm
