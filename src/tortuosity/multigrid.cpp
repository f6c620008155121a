// Two damped Jacobi sweeps, the residual's sum on the next coarser grid, its correction constant over the joined cells, two sweeps again.
// Single precision is enough: conjugate gradients correct what the preconditioner misses.
#include "tortuosity/multigrid.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace porepack::tortuosity {
namespace {

// A grid of half as many cells per side. Joined cells share one value; without the factor 1/2 the coarse grid would be twice as stiff.
ConductanceGrid coarser(const ConductanceGrid& fine) {
    ConductanceGrid grid{.periodic = fine.periodic, .axis = fine.axis};
    for (std::size_t a = 0; a < 3; ++a) grid.n[a] = (fine.n[a] + 1) / 2;
    grid.allocate();
    const auto stride = fine.strides();
    const auto coarse_stride = grid.strides();
    std::array<int, 3> at{};
    for (at[2] = 0; at[2] < fine.n[2]; ++at[2])
        for (at[1] = 0; at[1] < fine.n[1]; ++at[1])
            for (at[0] = 0; at[0] < fine.n[0]; ++at[0]) {
                std::size_t i = 0, coarse = 0;
                for (std::size_t a = 0; a < 3; ++a) {
                    i += static_cast<std::size_t>(at[a]) * stride[a];
                    coarse += static_cast<std::size_t>(at[a] / 2) * coarse_stride[a];
                }
                for (std::size_t a = 0; a < 3; ++a)
                    if (at[a] % 2 == 1 || at[a] + 1 == fine.n[a]) grid.face[a][coarse] += 0.5F * fine.face[a][i];
                for (std::size_t end = 0; end < 2; ++end)
                    if (!fine.plane[end].empty() && at[fine.axis] == (end == 0 ? 0 : fine.n[fine.axis] - 1))
                        grid.plane[end][grid.plane_index({at[0] / 2, at[1] / 2, at[2] / 2})] +=
                            0.5F * fine.plane[end][fine.plane_index(at)];
            }
    // In a periodic direction that is one cell wide a cell is its own neighbour.
    for (std::size_t a = 0; a < 3; ++a)
        if (grid.n[a] == 1) grid.face[a].assign(grid.size(), 0.0F);
    return grid;
}

// Damped Jacobi sweeps; the result is in `x` again.
void smooth(ConductanceGrid& grid, int sweeps, bool from_zero) {
    constexpr double damping = 0.8;
    for (int s = 0; s < sweeps; ++s) {
        const bool zero = from_zero && s == 0;
#pragma omp parallel for schedule(static)
        for (int k = 0; k < grid.n[2]; ++k)
            for_layer(grid, k, grid.x, [&](std::size_t i, double diagonal, double around) {
                const double old = zero ? 0.0 : static_cast<double>(grid.x[i]);
                const double sum = zero ? 0.0 : around;
                grid.scratch[i] = diagonal > 0.0 ? static_cast<float>(old + damping * ((grid.b[i] + sum) / diagonal - old)) : 0.0F;
            });
        grid.x.swap(grid.scratch);
    }
}

void cycle(std::vector<ConductanceGrid>& grids, std::size_t l) {
    ConductanceGrid& fine = grids[l];
    if (l + 1 == grids.size()) {
        smooth(fine, 40, true);
        return;
    }
    smooth(fine, 2, true);
    ConductanceGrid& coarse = grids[l + 1];
    const auto coarse_stride = coarse.strides();
    const auto coarse_of = [&](std::size_t i) {
        const auto nx = static_cast<std::size_t>(fine.n[0]), ny = static_cast<std::size_t>(fine.n[1]);
        return i % nx / 2 + i / nx % ny / 2 * coarse_stride[1] + i / (nx * ny) / 2 * coarse_stride[2];
    };
#pragma omp parallel for schedule(static)
    for (int kc = 0; kc < coarse.n[2]; ++kc) {
        const std::size_t first = static_cast<std::size_t>(kc) * coarse_stride[2];
        std::fill(coarse.b.begin() + static_cast<std::ptrdiff_t>(first),
                  coarse.b.begin() + static_cast<std::ptrdiff_t>(first + coarse_stride[2]), 0.0F);
        for (int k = 2 * kc; k < std::min(fine.n[2], 2 * kc + 2); ++k)
            for_layer(fine, k, fine.x, [&](std::size_t i, double diagonal, double around) {
                if (diagonal > 0.0) coarse.b[coarse_of(i)] += static_cast<float>(fine.b[i] + around - diagonal * fine.x[i]);
            });
    }
    cycle(grids, l + 1);
    const auto layer = static_cast<std::size_t>(fine.n[0]) * static_cast<std::size_t>(fine.n[1]);
#pragma omp parallel for schedule(static)
    for (int k = 0; k < fine.n[2]; ++k)
        for (std::size_t i = static_cast<std::size_t>(k) * layer; i < static_cast<std::size_t>(k + 1) * layer; ++i)
            fine.x[i] += coarse.x[coarse_of(i)];
    smooth(fine, 2, false);
}

}  // namespace

std::vector<ConductanceGrid> make_grids(ConductanceGrid finest) {
    std::vector<ConductanceGrid> grids;
    grids.push_back(std::move(finest));
    while (grids.size() < 12 && *std::max_element(grids.back().n.begin(), grids.back().n.end()) > 6) grids.push_back(coarser(grids.back()));
    return grids;
}

void v_cycle(std::vector<ConductanceGrid>& grids) {
    cycle(grids, 0);
}

}  // namespace porepack::tortuosity
