// A grid of cells that exchange a diffusing quantity through their faces, and loops over the grid; only for the sources of this folder.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "geometry/grid.hpp"

namespace porepack::tortuosity {

/// Finite volumes for Laplace's equation: conductance of the face between a cell and the next one along each axis (0: closed), and between
/// the cells at either end of `axis` and the plane of prescribed concentration there. The matrix is not stored: row i has the sum of the
/// cell's conductances on its diagonal, and minus each conductance in the neighbour's column.
struct ConductanceGrid {
    std::array<int, 3> n{};
    std::array<bool, 3> periodic{};
    std::size_t axis = 2;
    std::array<std::vector<float>, 3> face;   ///< to the next cell; of the last cell to the first where periodic, else 0
    std::array<std::vector<float>, 2> plane;  ///< of the cells at either plane; empty where the axis is periodic
    std::vector<float> x, b, scratch;         ///< solution and right-hand side of the preconditioner on this grid

    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
    }
    [[nodiscard]] std::array<std::size_t, 3> strides() const {
        return {1, static_cast<std::size_t>(n[0]), static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1])};
    }
    [[nodiscard]] std::array<int, 3> place(std::size_t i) const { return geometry::place_in(n, i); }
    [[nodiscard]] std::size_t plane_index(const std::array<int, 3>& at) const {
        const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        return static_cast<std::size_t>(at[v]) * static_cast<std::size_t>(n[u]) + static_cast<std::size_t>(at[u]);
    }
    [[nodiscard]] std::size_t plane_size() const { return size() / static_cast<std::size_t>(n[axis]); }
    /// All conductances closed, vectors of the right size.
    void allocate() {
        for (auto& conductances : face) conductances.assign(size(), 0.0F);
        for (auto& conductances : plane)
            if (!periodic[axis]) conductances.assign(plane_size(), 0.0F);
        x.resize(size());
        b.resize(size());
        scratch.resize(size());
    }
};

/// visit(cell, sum of its conductances, sum over neighbours of conductance times value) for all cells of one layer in z.
template <typename Value, typename Visit>
void for_layer(const ConductanceGrid& grid, int k, const Value& value, const Visit& visit) {
    const auto stride = grid.strides();
    std::array<int, 3> at{0, 0, k};
    for (at[1] = 0; at[1] < grid.n[1]; ++at[1]) {
        std::size_t i = static_cast<std::size_t>(k) * stride[2] + static_cast<std::size_t>(at[1]) * stride[1];
        for (at[0] = 0; at[0] < grid.n[0]; ++at[0], ++i) {
            double diagonal = 0.0, around = 0.0;
            for (std::size_t a = 0; a < 3; ++a) {
                const std::size_t around_the_box = stride[a] * static_cast<std::size_t>(grid.n[a] - 1);
                if (const float g = grid.face[a][i]; g > 0.0F) {
                    const std::size_t next = at[a] + 1 < grid.n[a] ? i + stride[a] : i - around_the_box;
                    diagonal += static_cast<double>(g);
                    around += static_cast<double>(g) * static_cast<double>(value[next]);
                }
                if (at[a] == 0 && !grid.periodic[a]) continue;
                const std::size_t previous = at[a] > 0 ? i - stride[a] : i + around_the_box;
                if (const float g = grid.face[a][previous]; g > 0.0F) {
                    diagonal += static_cast<double>(g);
                    around += static_cast<double>(g) * static_cast<double>(value[previous]);
                }
            }
            if (!grid.plane[0].empty()) {
                if (at[grid.axis] == 0) diagonal += static_cast<double>(grid.plane[0][grid.plane_index(at)]);
                if (at[grid.axis] + 1 == grid.n[grid.axis]) diagonal += static_cast<double>(grid.plane[1][grid.plane_index(at)]);
            }
            visit(i, diagonal, around);
        }
    }
}

/// put(cell, row of the matrix times `in`, diagonal) for all cells.
template <typename Put>
void multiply(const ConductanceGrid& grid, const std::vector<double>& in, const Put& put) {
#pragma omp parallel for schedule(static)
    for (int k = 0; k < grid.n[2]; ++k)
        for_layer(grid, k, in, [&](std::size_t i, double diagonal, double sum) { put(i, diagonal * in[i] - sum, diagonal); });
}

/// Sum of term(cell), layer by layer: independent of the number of threads.
template <typename Term>
double sum_over(const ConductanceGrid& grid, const Term& term) {
    const auto layer = static_cast<std::size_t>(grid.n[0]) * static_cast<std::size_t>(grid.n[1]);
    std::vector<double> parts(static_cast<std::size_t>(grid.n[2]), 0.0);
#pragma omp parallel for schedule(static)
    for (int k = 0; k < grid.n[2]; ++k)
        for (std::size_t i = static_cast<std::size_t>(k) * layer; i < static_cast<std::size_t>(k + 1) * layer; ++i)
            parts[static_cast<std::size_t>(k)] += term(i);
    double sum = 0.0;
    for (const double part : parts) sum += part;
    return sum;
}

template <typename Work>
void for_cells(const ConductanceGrid& grid, const Work& work) {
    const auto count = static_cast<std::ptrdiff_t>(grid.size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < count; ++i) work(static_cast<std::size_t>(i));
}

}  // namespace porepack::tortuosity
