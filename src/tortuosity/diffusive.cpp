// Diffusion through the pores: Laplace's equation on the pore voxels by conjugate gradients, preconditioned by one multigrid V-cycle.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "converters/percolation.hpp"
#include "core/error.hpp"
#include "tortuosity/conjugate_gradients.hpp"
#include "tortuosity/multigrid.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack::tortuosity {
using namespace core;
using namespace converters;
namespace {

// Conductances in units of D0 h, where h is the cube root of a voxel's volume: face area / distance of the centres / h. A plane of given
// concentration is half a voxel away from the centres. Only percolating pores (`percolation`) conduct.
ConductanceGrid finest_grid(const PhaseImage& image, const Percolation& percolation, const LinkCuts& cuts, std::size_t axis,
                            const std::array<bool, 3>& periodic) {
    ConductanceGrid grid{.n = image.grid.cells, .periodic = periodic, .axis = axis};
    grid.allocate();
    const auto stride = grid.strides();
    const auto& h = image.grid.spacing_m;
    const double scale = std::cbrt(h[0] * h[1] * h[2]);
    percolation.cells.for_each([&](std::size_t i) {
        const std::array<int, 3> at = grid.place(i);
        for (std::size_t a = 0; a < 3; ++a) {
            const auto g = static_cast<float>(h[0] * h[1] * h[2] / (h[a] * h[a] * scale));
            const bool last = at[a] + 1 == grid.n[a];
            std::array<int, 3> up{}, down{};
            up[a] = 1;
            down[a] = -1;
            if (a == axis && !periodic[a]) {
                if (at[a] == 0 && !cuts.closed(i, down)) grid.plane[0][grid.plane_index(at)] = 2.0F * g;
                if (last && !cuts.closed(i, up)) grid.plane[1][grid.plane_index(at)] = 2.0F * g;
            }
            if ((last && !periodic[a]) || grid.n[a] == 1) continue;
            const std::size_t next = last ? i - stride[a] * static_cast<std::size_t>(grid.n[a] - 1) : i + stride[a];
            if (percolation.cells.contains(next) && !cuts.closed(i, up)) grid.face[a][i] = g;
        }
    });
    return grid;
}

// The boundary conditions along the axis. Between planes: concentration 1 at the first, 0 at the last. Periodic: a mean gradient of one
// unit per layer; the unknown x is the deviation from it.
class ConcentrationDrop {
public:
    explicit ConcentrationDrop(const ConductanceGrid& grid)
        : grid_(grid), stride_(grid.strides()[grid.axis]), layers_(grid.n[grid.axis]), around_(grid.periodic[grid.axis]) {}

    [[nodiscard]] std::vector<double> right_hand_side() const {
        std::vector<double> b(grid_.size(), 0.0);
        for_cells(grid_, [&](std::size_t i) {
            if (around_)
                b[i] = static_cast<double>(grid_.face[grid_.axis][i]) - static_cast<double>(grid_.face[grid_.axis][previous(i)]);
            else if (layer_of(i) == 0)
                b[i] = static_cast<double>(grid_.plane[0][grid_.plane_index(grid_.place(i))]);
        });
        return b;
    }
    // The concentrations as they would be without grains.
    [[nodiscard]] std::vector<double> first_guess() const {
        std::vector<double> x(grid_.size(), 0.0);
        if (!around_) for_cells(grid_, [&](std::size_t i) { x[i] = 1.0 - (layer_of(i) + 0.5) / layers_; });
        return x;
    }
    // Through the plane at this end, or through all faces along the axis over the number of layers.
    [[nodiscard]] double flux(const std::vector<double>& x, int end) const {
        return sum_over(grid_, [&](std::size_t i) {
            if (around_) {
                const double g = static_cast<double>(grid_.face[grid_.axis][i]);
                if (g == 0.0) return 0.0;
                const std::size_t next = layer_of(i) + 1 < layers_ ? i + stride_ : i - stride_ * static_cast<std::size_t>(layers_ - 1);
                return g * (1.0 + x[next] - x[i]) / layers_;
            }
            if (layer_of(i) != (end == 0 ? 0 : layers_ - 1)) return 0.0;
            const auto g = static_cast<double>(grid_.plane[static_cast<std::size_t>(end)][grid_.plane_index(grid_.place(i))]);
            return g * (end == 0 ? 1.0 - x[i] : x[i]);
        });
    }

private:
    [[nodiscard]] int layer_of(std::size_t i) const { return static_cast<int>(i / stride_ % static_cast<std::size_t>(layers_)); }
    [[nodiscard]] std::size_t previous(std::size_t i) const {
        return layer_of(i) > 0 ? i - stride_ : i + stride_ * static_cast<std::size_t>(layers_ - 1);
    }
    const ConductanceGrid& grid_;
    std::size_t stride_;
    int layers_;
    bool around_;
};

}  // namespace

double diffusive_memory_bytes(double cells) {
    return 60.0 * cells;
}

DiffusiveResult diffusive_tortuosity(const PhaseImage& image, int along, std::array<bool, 3> periodic, const DiffusiveOptions& options,
                                     const LinkCuts& cuts) {
    const auto axis = static_cast<std::size_t>(along);
    DiffusiveResult result;
    double inside = 0.0, pores = 0.0;
    for (const std::uint8_t phase : image.phase) {
        inside += phase != Phase::outside ? 1.0 : 0.0;
        pores += phase == Phase::pore ? 1.0 : 0.0;
    }
    std::vector<ConductanceGrid> grids;
    {
        const Percolation percolation = find_percolating_cells(image, {.axis = along, .periodic = periodic}, cuts);
        result.porosity = pores / inside;
        result.porosity_flowing = static_cast<double>(percolation.cells.size()) / inside;
        grids = make_grids(finest_grid(image, percolation, cuts, axis, periodic));
    }
    const ConcentrationDrop drop(grids.front());
    std::vector<double> x = drop.first_guess();
    const ConjugateGradientResult solution = solve_by_conjugate_gradients(
        grids, drop.right_hand_side(), x,
        {.tolerance = options.tolerance, .maximum_iterations = options.maximum_iterations, .label = "tortuosity (diffusive)"});
    result.iterations = solution.iterations;
    result.residual = solution.residual;
    result.converged = solution.converged;
    if (!solution.converged)
        throw NumericalError(
            fmt::format("diffusion has not converged: residual {:.2e} after {} iterations", solution.residual, solution.iterations),
            {.allowed = fmt::format("{:.1e}", options.tolerance)});
    const double in = drop.flux(x, 0), out = periodic[axis] ? in : drop.flux(x, 1);
    result.flux_imbalance = std::abs(in - out) / in;
    // Without grains: g_axis for each cell of a layer, over the layers between the planes, or for one unit per layer.
    const auto& h = image.grid.spacing_m;
    const double g_axis = h[0] * h[1] * h[2] / (h[axis] * h[axis] * std::cbrt(h[0] * h[1] * h[2]));
    const int layers = image.grid.cells[axis];
    const double cells_per_layer = inside / layers;
    result.relative_diffusivity = 0.5 * (in + out) / (g_axis * cells_per_layer / (periodic[axis] ? 1.0 : layers));
    result.value = result.porosity / result.relative_diffusivity;
    result.concentration = std::move(x);
    return result;
}

DiffusiveLimit diffusive_limit(const std::array<double, 3>& sizes, const std::array<double, 3>& values) {
    const auto line = [&](std::size_t fine, std::size_t coarse) {
        return values[fine] - (values[coarse] - values[fine]) * sizes[fine] / (sizes[coarse] - sizes[fine]);
    };
    const double value = std::max(1.0, line(0, 1));
    return {value, std::max(std::abs(line(0, 2) - value), 0.25 * std::abs(values[0] - value))};
}

}  // namespace porepack::tortuosity
