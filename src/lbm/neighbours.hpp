// The nodes at the ends of a node's links.
#pragma once

#include <array>
#include <cstdint>

#include "lbm/domain.hpp"
#include "lbm/lattice.hpp"

namespace porepack::lbm {

/// Looks neighbours up along rows of cells: fast when the cells are requested in ascending order. For one thread.
class Neighbours {
public:
    explicit Neighbours(const Domain& domain);

    /// By direction q: the node at the end of the link from the node in `cell`, through periodic faces and into other
    /// slabs too, or -1 if there is none.
    [[nodiscard]] const std::array<std::int64_t, d3q19::directions>& of(std::size_t cell);
    /// All links of the node in `cell` end at nodes. Faster than of(); may be false for nodes at the faces of the grid.
    [[nodiscard]] bool inside(std::size_t cell);

private:
    void enter_row(std::size_t row);

    struct Row {
        const pore_space::CellSet* cells = nullptr;  // of the domain, or of the slab beyond
        std::int64_t first_node = 0;                 // of that set
        std::size_t first_cell = 0;
        std::size_t cell = 0;     // that was asked for last
        std::int64_t before = 0;  // nodes before it
        bool exists = false;
        std::array<int, 3> q{};  // to x - 1, x, x + 1; -1 where the lattice has none
    };
    [[nodiscard]] static std::int64_t rank(Row& row, std::size_t cell);

    const Domain& domain_;
    std::size_t row_ = static_cast<std::size_t>(-1);
    std::array<Row, 9> rows_;
    std::array<std::int64_t, d3q19::directions> found_{};
};

}  // namespace porepack::lbm
