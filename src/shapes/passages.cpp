// Throats narrower than a cell. A throat is detectable on the grid: along any path through it, even the solid cells' centres lie less than
// 0.87 cells deep, because the path's void points lie in those cells. So the search follows the path between two parts whose narrowest
// cell is the widest, tries a short straight line there, which is rotated and shifted until it is free, and closes the cells
// there when none is found, until no path is left.
#include "shapes/passages.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>
#include <vector>

#include "shapes/clearance.hpp"

namespace porepack::shapes {
namespace {

struct CellPath {
    std::size_t before, narrowest, after;
};

// The path from `part` to any other part with the maximum width of its narrowest cell (Dijkstra's search by width).
std::optional<CellPath> widest_path(const VoidGrid& grid, std::size_t part, const std::vector<char>& closed) {
    std::vector<std::size_t> from(grid.size(), grid.size());
    using Entry = std::pair<double, std::size_t>;
    std::priority_queue<Entry> open;
    for (std::size_t cell = 0; cell < grid.size(); ++cell)
        if (grid.part(cell) >= 0 && !grid.is_other_part(cell, part)) {
            from[cell] = cell;
            open.emplace(grid.depth(cell), cell);
        }
    while (!open.empty()) {
        const auto [width, cell] = open.top();
        open.pop();
        if (grid.is_other_part(cell, part)) {
            std::vector<std::size_t> cells_on_path = {cell};
            while (from[cells_on_path.back()] != cells_on_path.back()) cells_on_path.push_back(from[cells_on_path.back()]);
            std::size_t narrowest = 0;
            for (std::size_t k = 0; k < cells_on_path.size(); ++k)
                if (grid.depth(cells_on_path[k]) < grid.depth(cells_on_path[narrowest])) narrowest = k;
            return CellPath{cells_on_path[std::min(narrowest + 2, cells_on_path.size() - 1)], cells_on_path[narrowest],
                            cells_on_path[narrowest >= 2 ? narrowest - 2 : 0]};
        }
        for (const std::size_t next : grid.neighbours(cell)) {
            // A void point is at most 0.87 cells from its cell's centre.
            if (from[next] != grid.size() || closed[next] || grid.depth(next) < -0.87 * grid.cell_size()) continue;
            from[next] = cell;
            open.emplace(std::min(width, grid.depth(next)), next);
        }
    }
    return std::nullopt;
}

// Rotates and shifts a short line to maximum clearance; returns the part at its other end if it is free.
std::optional<std::size_t> pass(VoidGrid& grid, Vec3 middle, Vec3 direction, std::size_t part) {
    const double half = 1.5 * grid.cell_size();
    const auto free_width = [&](const Vec3& at, const Vec3& along) {
        return clearance(grid.capsules(), at - half * along, along, 2.0 * half);
    };
    double best = free_width(middle, direction);
    for (double step = 0.5; step > 1e-9 && best <= 0.0;) {
        const Vec3 e1 = direction.unitOrthogonal(), e2 = direction.cross(e1);
        const Vec3 old_middle = middle, old_direction = direction;
        for (int k = 0; k < 12; ++k) {
            const double angle = std::numbers::pi * k / 6.0;
            const Vec3 aside = std::cos(angle) * e1 + std::sin(angle) * e2;
            for (const auto& [at, along] : {std::pair<Vec3, Vec3>(old_middle + step * grid.cell_size() * aside, old_direction),
                                            std::pair<Vec3, Vec3>(old_middle, (old_direction + step * aside).normalized())})
                if (const double value = free_width(at, along); value > best) {
                    best = value;
                    middle = at;
                    direction = along;
                }
        }
        if (middle == old_middle && direction == old_direction) step *= 0.5;
    }
    if (best <= 0.0) return std::nullopt;
    const std::size_t one = grid.root(grid.part_of(middle - half * direction)), other = grid.root(grid.part_of(middle + half * direction));
    if (one == part && other != part) return other;
    if (other == part && one != part) return one;
    return std::nullopt;
}

}  // namespace

std::optional<std::size_t> joined_part(VoidGrid& grid, std::size_t part) {
    Vec3 point = grid.deepest(part);
    for (int step = 0; step < 80; ++step) {
        for (const std::size_t cell : grid.cells_around(point))
            if (grid.is_other_part(cell, part) && !blocked(grid.capsules(), point, grid.centre(cell)))
                return static_cast<std::size_t>(grid.part(cell));
        const Vec3 next = wider_place(grid.capsules(), point);
        if (next == point) break;
        point = next;
    }
    constexpr int maximum_throats = 24;
    std::vector<char> closed(grid.size(), 0);
    for (int throat = 0; throat < maximum_throats; ++throat) {
        const auto path = widest_path(grid, part, closed);
        if (!path) return std::nullopt;
        const auto [before, narrowest, after] = *path;
        Vec3 direction = grid.centre(after) - grid.centre(before);
        if (direction.norm() == 0.0) direction = Vec3::UnitZ();
        if (const auto found = pass(grid, grid.centre(narrowest), direction.normalized(), part)) return found;
        for (const std::size_t cell : grid.cells_around(grid.centre(narrowest))) closed[cell] = grid.part(cell) < 0;
        closed[narrowest] = 1;
    }
    return std::nullopt;
}

}  // namespace porepack::shapes
