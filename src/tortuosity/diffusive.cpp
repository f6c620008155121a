// Diffusion through the pores: Laplace's equation on the pore voxels by conjugate gradients, preconditioned by one multigrid V-cycle.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "pore_space/percolation.hpp"
#include "tortuosity/conjugate_gradients.hpp"
#include "tortuosity/cut_cells.hpp"
#include "tortuosity/multigrid.hpp"
#include "tortuosity/tortuosity.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {
namespace {

double volume_of_cell(const Grid& cells) {
    return cells.spacing_m[0] * cells.spacing_m[1] * cells.spacing_m[2];
}

// Of a face without solid, in units of D0 h, where h is the cube root of a cell's volume: face area / distance of the centres / h.
double face_conductance(const Grid& cells, std::size_t axis) {
    const double h = cells.spacing_m[axis], volume = volume_of_cell(cells);
    return volume / (h * h * std::cbrt(volume));
}

// A plane of given concentration is half a voxel away from the centres. Only percolating pores (`percolation`) conduct.
ConductanceGrid voxel_grid(const PhaseImage& image, const Percolation& percolation, const LinkCuts& cuts, const Drive& drive) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    const std::array<bool, 3>& periodic = drive.periodic;
    ConductanceGrid grid{.n = image.grid.cells, .periodic = periodic, .axis = axis};
    grid.allocate();
    const auto stride = grid.strides();
    percolation.cells.for_each([&](std::size_t i) {
        const std::array<int, 3> at = grid.place(i);
        for (std::size_t a = 0; a < 3; ++a) {
            const auto g = static_cast<float>(face_conductance(image.grid, a));
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

// What turns a flux into a tortuosity factor: the section lies between two planes across the axis, numbered from the first face of the
// grid.
struct Evaluated {
    int first = 0, last = 0;
    double area = 0.0;      // of the container in such a plane, in units of the conductance of a face without solid: D0 h
    double porosity = 0.0;  // between the planes
};

Evaluated voxels_between(const PhaseImage& image, std::size_t axis, int first, int last) {
    const std::array<std::size_t, 3> strides = {1, image.grid.index(0, 1, 0), image.grid.index(0, 0, 1)};
    const auto layers = static_cast<std::size_t>(image.grid.cells[axis]);
    double inside = 0.0, pores = 0.0;
    for (std::size_t i = 0; i < image.phase.size(); ++i) {
        const int layer = static_cast<int>(i / strides[axis] % layers);
        if (layer < first || layer >= last) continue;
        inside += image.phase[i] != Phase::outside ? 1.0 : 0.0;
        pores += image.phase[i] == Phase::pore ? 1.0 : 0.0;
    }
    return {.first = first, .last = last, .area = face_conductance(image.grid, axis) * inside / (last - first), .porosity = pores / inside};
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
    // Mean over the open faces of a plane.
    [[nodiscard]] double concentration(const std::vector<double>& x, int plane) const {
        if (plane == 0 || plane == layers_) return plane == 0 ? 1.0 : 0.0;
        const auto mean_of = [&](const auto& value) {
            return sum_over(grid_, [&](std::size_t i) {
                return layer_of(i) + 1 == plane ? static_cast<double>(grid_.face[grid_.axis][i]) * value(i) : 0.0;
            });
        };
        return mean_of([&](std::size_t i) { return 0.5 * (x[i] + x[i + stride_]); }) / mean_of([](std::size_t) { return 1.0; });
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

DiffusiveResult solve(ConductanceGrid finest, const Evaluated& section, const DiffusiveOptions& options) {
    std::vector<ConductanceGrid> grids = make_grids(std::move(finest));
    const ConcentrationDrop drop(grids.front());
    std::vector<double> x = drop.first_guess();
    const ConjugateGradientResult solution = solve_by_conjugate_gradients(
        grids, drop.right_hand_side(), x,
        {.tolerance = options.tolerance, .max_iterations = options.max_iterations, .label = "tortuosity (diffusive)"});
    if (!solution.converged)
        throw NumericalError(
            fmt::format("diffusion has not converged: residual {:.2e} after {} iterations", solution.residual, solution.iterations),
            {.allowed = fmt::format("{:.1e}", options.tolerance)});
    const bool around = grids.front().periodic[grids.front().axis];
    const double in = drop.flux(x, 0), out = around ? in : drop.flux(x, 1);
    // Without grains the flux is the area times the drop of the concentration per layer.
    const double per_layer =
        around ? 1.0 : (drop.concentration(x, section.first) - drop.concentration(x, section.last)) / (section.last - section.first);
    DiffusiveResult result{.relative_diffusivity = 0.5 * (in + out) / (section.area * per_layer),
                           .porosity = section.porosity,
                           .iterations = solution.iterations,
                           .residual = solution.residual,
                           .flux_imbalance = std::abs(in - out) / in,
                           .converged = true,
                           .concentration = std::move(x)};
    result.value = result.porosity / result.relative_diffusivity;
    return result;
}

double flowing_share(const PhaseImage& image, const Percolation& percolation) {
    const auto pores = std::count(image.phase.begin(), image.phase.end(), static_cast<std::uint8_t>(Phase::pore));
    return static_cast<double>(percolation.cells.size()) / static_cast<double>(pores);
}

DiffusiveResult on_voxels(const PhaseImage& image, const Drive& drive, int first, int last, const DiffusiveOptions& options,
                          const LinkCuts& cuts) {
    const Percolation percolation = find_percolating_cells(image, drive, cuts);
    DiffusiveResult result = solve(voxel_grid(image, percolation, cuts, drive),
                                   voxels_between(image, static_cast<std::size_t>(drive.axis), first, last), options);
    result.porosity_flowing = result.porosity * flowing_share(image, percolation);
    return result;
}

}  // namespace

double diffusive_memory_bytes(double cells) {
    return 60.0 * cells;
}

DiffusiveResult diffusive_tortuosity(const PhaseImage& image, int axis, std::array<bool, 3> periodic, const DiffusiveOptions& options,
                                     const LinkCuts& cuts) {
    return on_voxels(image, {.axis = axis, .periodic = periodic}, 0, image.grid.cells[static_cast<std::size_t>(axis)], options, cuts);
}

DiffusiveResult diffusive_on_grid(const PoreSpace& space, double voxel_size_m, Axis along, const DiffusiveOptions& options) {
    const auto axis = static_cast<std::size_t>(along);
    const PhaseImage image = space.voxelise_at(voxel_size_m);
    const Grid& grid = image.grid;
    const Drive drive{.axis = static_cast<int>(axis), .periodic = space.periodic_sides()};
    const LinkCuts cuts = space.link_cuts(image, drive);
    const auto plane_at = [&](double z) { return static_cast<int>(std::lround((z - grid.origin_m[2]) / grid.spacing_m[2])); };
    const int first = axis == 2 ? plane_at(space.section.z0_m) : 0, last = axis == 2 ? plane_at(space.section.z1_m) : grid.cells[axis];
    const std::optional<FlowWalls> walls = space.walls();
    if (!walls) return on_voxels(image, drive, first, last, options, cuts);
    const Percolation percolation = find_percolating_cells(image, drive, cuts);
    const double h = grid.spacing_m[axis], area_m2 = axis == 2 ? space.container.vessel().mean_area(space.section.interval())
                                                               : space.container.size()[axis == 0 ? 1 : 0] * grid.cells[2] * h;
    const double porosity = options.porosity > 0.0 ? options.porosity : space.porosity().value;
    const double faces = area_m2 * h / volume_of_cell(grid);
    CutCells cut = cut_cells(image, percolation, cuts, *walls, drive);
    for (std::size_t a = 0; a < 3; ++a)  // 1 unless the voxels of a periodic box are no cubes
        for (float& conductance : cut.grid.face[a]) conductance *= static_cast<float>(face_conductance(grid, a));
    for (auto& plane : cut.grid.plane)
        for (float& conductance : plane) conductance *= static_cast<float>(face_conductance(grid, axis));
    DiffusiveResult result = solve(
        std::move(cut.grid), {.first = first, .last = last, .area = face_conductance(grid, axis) * faces, .porosity = porosity}, options);
    result.thin_solid = cut.thin_solid;
    result.porosity_flowing = result.porosity * flowing_share(image, percolation);
    return result;
}

}  // namespace porepack::tortuosity
