#include "tortuosity/pore_lattice.hpp"
#include "tortuosity/uses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace porepack::tortuosity {
namespace {

// For each of the 256 patterns of pore cells among the eight at a corner (bit x + 2 y + 4 z): are they connected through faces?
std::array<bool, 256> joined_corners() {
    std::array<bool, 256> joined{};
    for (unsigned mask = 1; mask < 256; ++mask) {
        unsigned reached = mask & (~mask + 1);  // its lowest cell
        for (int round = 0; round < 8; ++round)
            for (unsigned cell = 0; cell < 8; ++cell)
                if ((reached >> cell & 1U) != 0)
                    for (const unsigned axis : {1U, 2U, 4U}) reached |= mask & (1U << (cell ^ axis));
        joined[mask] = reached == mask;
    }
    return joined;
}

int sign(int x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

}  // namespace

bool VoxelSight::is_pore(Corner cell) const {
    for (std::size_t a = 0; a < 3; ++a) {
        const int n = lattice_.cells[a];
        if (cell[a] >= 0 && cell[a] < n) continue;
        if (!lattice_.periodic[a]) return false;
        cell[a] = (cell[a] % n + n) % n;
    }
    return image_.phase[image_.grid.index(cell[0], cell[1], cell[2])] == Phase::pore;
}

bool VoxelSight::joined(const Corner& cell, std::size_t axis, int direction) const {
    Corner other = cell;
    other[axis] += direction;
    if (!is_pore(cell) || !is_pore(other)) return false;
    if (cuts_.empty()) return true;
    Corner place = cell, step{};
    step[axis] = direction;
    for (std::size_t a = 0; a < 3; ++a)
        if (lattice_.periodic[a]) place[a] = (place[a] % lattice_.cells[a] + lattice_.cells[a]) % lattice_.cells[a];
    return !cuts_.closed(image_.grid.index(place[0], place[1], place[2]), step);
}

bool VoxelSight::all_joined(const Corner& low, const Corner& size) const {
    const int count = size[0] * size[1] * size[2];
    const auto place = [&](int i) {
        return Corner{low[0] + i % size[0], low[1] + i / size[0] % size[1], low[2] + i / (size[0] * size[1])};
    };
    const std::array<int, 3> stride = {1, size[0], size[0] * size[1]};
    unsigned pores = 0;
    for (int i = 0; i < count; ++i)
        if (is_pore(place(i))) pores |= 1U << static_cast<unsigned>(i);
    unsigned reached = pores & (~pores + 1);  // its lowest cell
    for (int round = 0; round < count; ++round)
        for (int i = 0; i < count; ++i)
            for (std::size_t a = 0; a < 3; ++a) {
                const Corner at = place(i);
                if (at[a] + 1 == low[a] + size[a] || !joined(at, a, 1)) continue;
                const unsigned both = 1U << static_cast<unsigned>(i) | 1U << static_cast<unsigned>(i + stride[a]);
                if ((reached & both) != 0) reached |= both;
            }
    return pores != 0 && reached == pores;
}

bool VoxelSight::open(const Corner& at) const {
    static const std::array<bool, 256> joined = joined_corners();
    unsigned mask = 0;
    for (int cell = 0; cell < 8; ++cell)
        if (is_pore({at[0] - 1 + (cell & 1), at[1] - 1 + (cell >> 1 & 1), at[2] - 1 + (cell >> 2 & 1)})) mask |= 1U << cell;
    return joined[mask] && (cuts_.empty() || all_joined({at[0] - 1, at[1] - 1, at[2] - 1}, {2, 2, 2}));
}

// A step with a common divisor passes through corners on the way, where it must be possible to turn: it is divided there. Each part then
// runs along an edge (two components are zero), within a plane of faces (one), or through the interior of cells.
bool VoxelSight::visible(const Corner& from, const Corner& step) const {
    const int parts = std::gcd(std::gcd(std::abs(step[0]), std::abs(step[1])), std::abs(step[2]));
    if (parts == 0) return true;
    const Corner part = {step[0] / parts, step[1] / parts, step[2] / parts};
    const int flat = (part[0] == 0 ? 1 : 0) + (part[1] == 0 ? 1 : 0) + (part[2] == 0 ? 1 : 0);
    Corner at = from;
    for (int p = 0; p < parts; ++p) {
        if (p > 0 && !open(at)) return false;
        bool free = true;
        if (flat == 0) {
            free = through_cells(at, part);
        } else {
            const std::size_t first = part[0] == 0 ? 0 : part[1] == 0 ? 1 : 2;
            free = flat == 1 ? along_face(at, part, first) : along_edge(at, part, part[0] != 0 ? 0 : part[1] != 0 ? 1 : 2);
        }
        if (!free) return false;
        for (std::size_t a = 0; a < 3; ++a) at[a] += part[a];
    }
    return true;
}

// Four cells share an edge.
bool VoxelSight::along_edge(const Corner& from, const Corner& step, std::size_t axis) const {
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    Corner cell = from;
    if (step[axis] < 0) --cell[axis];
    const auto pore_at = [&](int db, int dc) {
        Corner at = cell;
        at[b] += db;
        at[c] += dc;
        return is_pore(at);
    };
    if (!cuts_.empty()) {
        Corner low = cell, size = {2, 2, 2};
        --low[b];
        --low[c];
        size[axis] = 1;
        return all_joined(low, size);
    }
    const bool p = pore_at(-1, -1), q = pore_at(0, -1), r = pore_at(-1, 0), s = pore_at(0, 0);
    // Two pores across the edge's diagonal need a third one that joins them by faces; otherwise any pore leaves the edge free.
    return (p && s) || (q && r) ? (p && q) || (q && s) || (s && r) || (r && p) : p || q || r || s;
}

// A path within a plane of faces, each with a cell on either side: it continues where the cells of one side are both pore.
bool VoxelSight::along_face(const Corner& from, const Corner& step, std::size_t normal) const {
    const std::size_t a = (normal + 1) % 3, b = (normal + 2) % 3;
    Corner cell = from;
    if (step[a] < 0) --cell[a];
    if (step[b] < 0) --cell[b];
    const auto sides = [&] {
        Corner below = cell;
        --below[normal];
        return (is_pore(cell) ? 1U : 0U) | (is_pore(below) ? 2U : 0U);
    };
    unsigned open_sides = sides();
    if (open_sides == 0) return false;
    const int na = std::abs(step[a]), nb = std::abs(step[b]);
    // The sides on which the next cell can be entered.
    const auto enter = [&](std::size_t along) {
        const int direction = sign(step[along]);
        Corner below = cell;
        --below[normal];
        const unsigned next = (joined(cell, along, direction) ? 1U : 0U) | (joined(below, along, direction) ? 2U : 0U);
        cell[along] += direction;
        return next;
    };
    for (int ca = 1, cb = 1; ca < na || cb < nb;) {
        // The crossings are at ca/na and cb/nb of the path, never together: na and nb have no common divisor.
        const bool first = static_cast<long>(ca) * nb < static_cast<long>(cb) * na;
        ++(first ? ca : cb);
        const unsigned next = enter(first ? a : b);
        if ((open_sides & next) == 0) return false;
        open_sides = sides();
    }
    return true;
}

bool VoxelSight::through_cells(const Corner& from, const Corner& step) const {
    Corner cell = from;
    // The m-th plane across axis a is crossed at the fraction m / n[a] of the path. Multiplied by n[0] n[1] n[2], all crossings are whole
    // numbers, so that paths exactly through an edge or a corner are recognised without rounding.
    std::array<long, 3> n{}, crossed{1, 1, 1};
    for (std::size_t a = 0; a < 3; ++a) {
        n[a] = std::abs(step[a]);
        if (step[a] < 0) --cell[a];
    }
    if (!is_pore(cell)) return false;
    const std::array<long, 3> scale = {n[1] * n[2], n[0] * n[2], n[0] * n[1]};
    while (true) {
        const std::array<long, 3> at = {crossed[0] * scale[0], crossed[1] * scale[1], crossed[2] * scale[2]};
        const long next = std::min(at[0], std::min(at[1], at[2]));
        if (next >= n[0] * n[1] * n[2]) return true;
        int together = 0;
        bool beside = false;  // through an edge: one of the cells beside it must be pore, and joined with both
        Corner there = cell;
        for (std::size_t a = 0; a < 3; ++a) {
            if (at[a] != next) continue;
            ++together;
            there[a] += sign(step[a]);
            beside = beside || joined(cell, a, sign(step[a]));
            ++crossed[a];
        }
        if (!is_pore(there) || !beside) return false;
        if (together > 1 && !cuts_.empty()) {
            Corner low{}, size{};
            for (std::size_t a = 0; a < 3; ++a) {
                low[a] = std::min(cell[a], there[a]);
                size[a] = 1 + std::abs(there[a] - cell[a]);
            }
            if (!all_joined(low, size)) return false;
        }
        cell = there;
    }
}

}  // namespace porepack::tortuosity
