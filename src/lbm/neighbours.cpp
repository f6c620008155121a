#include "lbm/neighbours.hpp"

#include <algorithm>

namespace porepack::lbm {
using namespace converters;

Neighbours::Neighbours(const Domain& domain) : domain_(domain) {
    for (int at = 0; at < 9; ++at)
        for (int dx = -1; dx <= 1; ++dx) {
            int& q = rows_[static_cast<std::size_t>(at)].q[static_cast<std::size_t>(dx + 1)];
            q = -1;
            for (int other = 0; other < d3q19::directions; ++other)
                if (d3q19::c[static_cast<std::size_t>(other)] == std::array<int, 3>{dx, at % 3 - 1, at / 3 - 1}) q = other;
        }
}

void Neighbours::enter_row(std::size_t row, int x) {
    row_ = row;
    const auto ny = static_cast<std::size_t>(domain_.grid.cells[1]);
    const int y = static_cast<int>(row % ny), z = static_cast<int>(row / ny);
    for (int at = 0; at < 9; ++at) {
        Row& near = rows_[static_cast<std::size_t>(at)];
        std::array<int, 3> place = {0, y, z};
        near.exists = step_in_grid(domain_.grid, domain_.drive, place, {0, at % 3 - 1, at / 3 - 1});
        if (!near.exists) continue;
        near.first_cell = static_cast<std::int32_t>(domain_.grid.index(0, place[1], place[2]));
        const std::size_t there = static_cast<std::size_t>(near.first_cell) / static_cast<std::size_t>(domain_.grid.cells[0]);
        near.end = domain_.row_node[there + 1];
        const auto begin = domain_.cell.begin() + domain_.row_node[there];
        near.next = std::lower_bound(begin, domain_.cell.begin() + near.end, near.first_cell + x - 1) - domain_.cell.begin();
    }
}

const std::array<std::int64_t, d3q19::directions>& Neighbours::of(std::size_t node) {
    const int nx = domain_.grid.cells[0];
    const std::int32_t cell = domain_.cell[node];
    const auto row = static_cast<std::size_t>(cell / nx);
    const int x = cell % nx;
    if (row != row_ || (rows_[4].next < rows_[4].end && domain_.cell[static_cast<std::size_t>(rows_[4].next)] > cell)) enter_row(row, x);
    const auto cell_of = [&](std::int64_t at) { return domain_.cell[static_cast<std::size_t>(at)]; };
    for (Row& near : rows_) {
        const std::int32_t middle = near.first_cell + x;
        while (near.exists && near.next < near.end && cell_of(near.next) < middle - 1) ++near.next;
        std::int64_t at = near.next;
        for (int dx = -1; dx <= 1; ++dx) {
            const int q = near.q[static_cast<std::size_t>(dx + 1)];
            const bool inside = x + dx >= 0 && x + dx < nx;
            while (near.exists && inside && at < near.end && cell_of(at) < middle + dx) ++at;
            if (q < 0) continue;
            std::int64_t& found = found_[static_cast<std::size_t>(q)];
            found = -1;
            if (!near.exists) continue;
            if (inside) {
                if (at < near.end && cell_of(at) == middle + dx) found = at;
            } else if (domain_.drive.periodic[0]) {
                const auto there = static_cast<std::size_t>(near.first_cell) + static_cast<std::size_t>((x + dx + nx) % nx);
                found = domain_.node_at(place_in_grid(domain_.grid, there));
            }
        }
    }
    return found_;
}

}  // namespace porepack::lbm
