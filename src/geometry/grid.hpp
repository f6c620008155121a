// Regular grids and the fields on them, in metres.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace porepack::inline geometry {

/// (i, j, k) of the index (k ny + j) nx + i.
[[nodiscard]] inline std::array<int, 3> place_in(const std::array<int, 3>& cells, std::size_t index) {
    const auto nx = static_cast<std::size_t>(cells[0]), ny = static_cast<std::size_t>(cells[1]);
    return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny), static_cast<int>(index / (nx * ny))};
}

/// The layers along z of a larger grid that a grid holds.
struct Slab {
    int first = 0;   ///< of the larger grid, in which layer k has number first + k; -1 is its last one, beyond a periodic side
    int layers = 0;  ///< of the larger grid; 0: no slab, but a whole grid
    std::array<int, 2> halo = {0, 0};  ///< layers at its lower and upper side that belong to other slabs
};

/// A regular grid of cells; cell (i, j, k) has index (k ny + j) nx + i and its centre at origin + (i + 1/2, ...) spacing.
struct Grid {
    std::array<int, 3> cells = {0, 0, 0};
    std::array<double, 3> origin_m = {0, 0, 0};
    std::array<double, 3> spacing_m = {1, 1, 1};
    Slab slab = {};  ///< the origin stays that of the larger grid, so that centres have the same bits
    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cells[2]);
    }
    [[nodiscard]] std::size_t index(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(cells[1]) + static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(cells[0]) +
               static_cast<std::size_t>(i);
    }
    /// The inverse of index().
    [[nodiscard]] std::array<int, 3> place(std::size_t cell) const { return place_in(cells, cell); }
    /// Calls visit(index) for the cells that share a face with this one: before and after it along x, y and z, through periodic sides too.
    template <typename Visit>
    void for_neighbours(std::size_t cell, const Visit& visit, const std::array<bool, 3>& periodic = {false, false, false}) const {
        const std::array<int, 3> at = place(cell);
        std::size_t step = 1;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto n = static_cast<std::size_t>(cells[a]), i = static_cast<std::size_t>(at[a]);
            if (i > 0 || periodic[a]) visit(i > 0 ? cell - step : cell + (n - 1) * step);
            if (i + 1 < n || periodic[a]) visit(i + 1 < n ? cell + step : cell - (n - 1) * step);
            step *= n;
        }
    }
    [[nodiscard]] double centre(int axis, int i) const {
        const auto a = static_cast<std::size_t>(axis);
        return origin_m[a] + ((axis == 2 ? layer(i) : i) + 0.5) * spacing_m[a];
    }

    [[nodiscard]] bool is_slab() const { return slab.layers > 0; }
    /// The number of layer k along z in the larger grid.
    [[nodiscard]] int layer(int k) const {
        if (slab.layers == 0) return k;
        const int layer = slab.first + k;
        return layer < 0 ? layer + slab.layers : layer < slab.layers ? layer : layer - slab.layers;
    }
    /// Calls visit(k) for the layers k whose numbers in the larger grid are `from` to `to`.
    template <typename Visit>
    void for_layers(int from, int to, const Visit& visit) const {
        const int turns = is_slab() ? 1 : 0;  // layers beyond a periodic side
        for (int turn = -turns; turn <= turns; ++turn) {
            const int shift = turn * slab.layers - slab.first;
            for (int k = std::max(0, from + shift); k <= std::min(cells[2] - 1, to + shift); ++k) visit(k);
        }
    }
    /// Cells along an axis, of the larger grid.
    [[nodiscard]] int whole_cells(std::size_t axis) const { return axis == 2 && is_slab() ? slab.layers : cells[axis]; }
    /// The layers [first, end) of this whole grid, with one more on both sides where there is one. All layers: no slab.
    [[nodiscard]] Grid slab_of(int first, int end, bool periodic) const;
    /// Without the layers of other slabs.
    [[nodiscard]] Grid without_halo() const;
};

inline Grid Grid::slab_of(int first, int end, bool periodic) const {
    Grid part = *this;
    if (first == 0 && end == cells[2]) return part;
    part.slab = {.layers = cells[2], .halo = {first > 0 || periodic ? 1 : 0, end < cells[2] || periodic ? 1 : 0}};
    part.slab.first = first - part.slab.halo[0];
    part.cells[2] = end - first + part.slab.halo[0] + part.slab.halo[1];
    return part;
}

inline Grid Grid::without_halo() const {
    Grid own = *this;
    own.slab.first += slab.halo[0];
    own.cells[2] -= slab.halo[0] + slab.halo[1];
    own.slab.halo = {0, 0};
    return own;
}

/// Phase of a cell, with the value stored in images.
struct Phase {
    static constexpr std::uint8_t grain = 0, pore = 1, outside = 2;
};

/// A phase image with notes (for instance the container) that are kept in the file as field data.
struct PhaseImage {
    Grid grid;
    std::vector<std::uint8_t> phase;
    std::map<std::string, std::string> notes;
};

/// Velocity in m/s (3 numbers per cell) and pressure in Pa; single precision.
struct FlowImage {
    Grid grid;
    std::vector<float> velocity_m_per_s;
    std::vector<float> pressure_Pa;
    std::vector<std::uint8_t> phase;
    std::map<std::string, std::string> notes;
};

/// A flow image that is made while it is written, some layers of cells at a time.
struct LayeredFlow {
    Grid grid;                        ///< the whole one
    std::array<int, 2> own = {0, 0};  ///< [first, end): its layers along z that this part of the computation has
    std::map<std::string, std::string> notes;
    std::function<FlowImage(int first, int end)> layers;  ///< [first, end) of its own; by several threads; empty: no flow was kept
    [[nodiscard]] FlowImage of_own() const { return layers(own[0], own[1]); }
};

}  // namespace porepack::inline geometry
