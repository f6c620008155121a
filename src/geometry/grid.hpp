// Regular grids and the fields on them, in metres.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace porepack::geometry {

/// (i, j, k) of the index (k ny + j) nx + i.
[[nodiscard]] inline std::array<int, 3> place_in(const std::array<int, 3>& cells, std::size_t index) {
    const auto nx = static_cast<std::size_t>(cells[0]), ny = static_cast<std::size_t>(cells[1]);
    return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny), static_cast<int>(index / (nx * ny))};
}

/// A regular grid of cells; cell (i, j, k) has index (k ny + j) nx + i and its centre at origin + (i + 1/2, ...) spacing.
struct Grid {
    std::array<int, 3> cells = {0, 0, 0};
    std::array<double, 3> origin_m = {0, 0, 0};
    std::array<double, 3> spacing_m = {1, 1, 1};
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
        return origin_m[a] + (i + 0.5) * spacing_m[a];
    }
};

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
    Grid grid;
    std::map<std::string, std::string> notes;
    std::function<FlowImage(int first, int end)> layers;  ///< [first, end) along z; empty: no flow was kept
    [[nodiscard]] FlowImage whole() const { return layers(0, grid.cells[2]); }
};

}  // namespace porepack::geometry
