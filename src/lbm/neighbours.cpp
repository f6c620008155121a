#include "lbm/neighbours.hpp"
#include "lbm/uses.hpp"

#include <bit>
#include <cstdint>

namespace porepack::lbm {
namespace {

constexpr auto none = static_cast<std::size_t>(-2);  // no cell, nor the one before a cell

}  // namespace

Neighbours::Neighbours(const Domain& domain) : domain_(domain) {
    for (int at = 0; at < 9; ++at)
        for (int dx = -1; dx <= 1; ++dx) {
            int& q = rows_[static_cast<std::size_t>(at)].q[static_cast<std::size_t>(dx + 1)];
            q = -1;
            for (int other = 0; other < d3q19::directions; ++other)
                if (d3q19::c[static_cast<std::size_t>(other)] == std::array<int, 3>{dx, at % 3 - 1, at / 3 - 1}) q = other;
        }
}

void Neighbours::enter_row(std::size_t row) {
    row_ = row;
    const auto ny = static_cast<std::size_t>(domain_.grid.cells[1]);
    const int y = static_cast<int>(row % ny), z = static_cast<int>(row / ny);
    for (int at = 0; at < 9; ++at) {
        Row& near = rows_[static_cast<std::size_t>(at)];
        std::array<int, 3> place = {0, y, z};
        const int up = at / 3 - 1;
        const auto side = static_cast<std::size_t>(up < 0 ? 0 : 1);
        const bool leaves = z + up < 0 || z + up >= domain_.grid.cells[2];
        near.cells = leaves && domain_.beyond[side].has_grid() ? &domain_.beyond[side] : &domain_.cells;
        const bool beyond = near.cells != &domain_.cells;
        near.first_node = beyond ? static_cast<std::int64_t>(domain_.first_beyond(side)) : 0;
        near.exists = step_in_grid(domain_.grid, domain_.drive, place, {0, at % 3 - 1, beyond ? 0 : up});
        if (!near.exists) continue;
        near.first_cell = domain_.grid.index(0, place[1], beyond ? 0 : place[2]);
        near.cell = none;
    }
}

// Nodes before `cell`. A row is passed in ascending order: mostly the next cell is asked for, or one a few cells further.
std::int64_t Neighbours::rank(Row& row, std::size_t cell) {
    const CellSet& cells = *row.cells;
    if (cell == row.cell + 1) {
        row.before += cells.contains(row.cell) ? 1 : 0;
    } else if (cell > row.cell && cell / 64 == row.cell / 64) {
        const std::uint64_t between = ((std::uint64_t{1} << (cell - row.cell)) - 1) << (row.cell % 64);
        row.before += std::popcount(cells.word(cell / 64) & between);
    } else if (cell != row.cell) {
        row.before = cells.rank(cell);
    }
    row.cell = cell;
    return row.before;
}

bool Neighbours::inside(std::size_t cell) {
    const auto nx = static_cast<std::size_t>(domain_.grid.cells[0]);
    const std::size_t row = cell / nx, x = cell - row * nx;
    if (row != row_) enter_row(row);
    if (x == 0 || x + 1 == nx || domain_.cuts.at(cell)) return false;
    for (std::size_t at = 0; at < rows_.size(); ++at) {
        if (!rows_[at].exists) return false;
        const bool diagonal = at % 2 == 0 && at != 4;  // the lattice has one link to such a row
        const std::size_t first = rows_[at].first_cell + x - 1, shift = first % 64;
        std::uint64_t three = rows_[at].cells->word(first / 64) >> shift;
        if (shift > 61) three |= rows_[at].cells->word(first / 64 + 1) << (64 - shift);
        const std::uint64_t needed = diagonal ? 2 : 7;
        if ((three & needed) != needed) return false;
    }
    return true;
}

const std::array<std::int64_t, d3q19::directions>& Neighbours::of(std::size_t cell) {
    const int nx = domain_.grid.cells[0];
    const std::size_t row = cell / static_cast<std::size_t>(nx);
    const int x = static_cast<int>(cell - row * static_cast<std::size_t>(nx));
    if (row != row_) enter_row(row);
    for (Row& near : rows_) {
        std::int64_t node = -1;  // in the first cell of the three that exists
        for (int dx = -1; dx <= 1; ++dx) {
            const bool inside = near.exists && x + dx >= 0 && x + dx < nx;
            const std::size_t there = near.first_cell + static_cast<std::size_t>(inside ? x + dx : 0);
            const bool fluid = inside && near.cells->contains(there);
            if (inside && node < 0) node = near.first_node + rank(near, there);
            if (const int q = near.q[static_cast<std::size_t>(dx + 1)]; q >= 0) {
                std::int64_t& found = found_[static_cast<std::size_t>(q)];
                found = fluid ? node : -1;
                if (near.exists && !inside && domain_.drive.periodic[0])
                    if (const auto beyond = near.cells->find(near.first_cell + static_cast<std::size_t>((x + dx + nx) % nx)); beyond >= 0)
                        found = near.first_node + beyond;
            }
            if (fluid) ++node;
        }
    }
    if (const std::uint32_t closed = domain_.cuts.links(cell); closed != 0)
        for (std::size_t q = 1; q < d3q19::directions; ++q)
            if ((closed & LinkCuts::bit(d3q19::c[q])) != 0) found_[q] = -1;
    return found_;
}

}  // namespace porepack::lbm
