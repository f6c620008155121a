#include "lbm/neighbours.hpp"

#include <bit>

namespace porepack::lbm {
using namespace converters;
namespace {

constexpr auto none = static_cast<std::size_t>(-2);  // no word, nor the one before a word

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
        near.exists = step_in_grid(domain_.grid, domain_.drive, place, {0, at % 3 - 1, at / 3 - 1});
        if (!near.exists) continue;
        near.first_cell = domain_.grid.index(0, place[1], place[2]);
        near.word = none;
    }
}

// Nodes before `cell`. A row is passed in ascending order, so that mostly the same word is asked again, or the next one.
std::int64_t Neighbours::rank(Row& row, std::size_t cell) const {
    const std::size_t word = cell / 64;
    if (word != row.word) {
        row.before = word == row.word + 1 ? row.before + std::popcount(domain_.cells.word(row.word)) : domain_.cells.rank(64 * word);
        row.word = word;
    }
    return row.before + std::popcount(domain_.cells.word(word) & ((std::uint64_t{1} << (cell % 64)) - 1));
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
            const bool fluid = inside && domain_.cells.contains(there);
            if (inside && node < 0) node = rank(near, there);
            if (const int q = near.q[static_cast<std::size_t>(dx + 1)]; q >= 0) {
                std::int64_t& found = found_[static_cast<std::size_t>(q)];
                found = fluid ? node : -1;
                if (near.exists && !inside && domain_.drive.periodic[0])
                    found = domain_.cells.find(near.first_cell + static_cast<std::size_t>((x + dx + nx) % nx));
            }
            if (fluid) ++node;
        }
    }
    return found_;
}

}  // namespace porepack::lbm
