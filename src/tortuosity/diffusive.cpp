// Diffusion through the pores: Laplace's equation on the pore voxels by conjugate gradients, preconditioned by one multigrid V-cycle.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "converters/percolation.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack {
namespace {

// One grid: conductances of the faces to the next cell along each axis (0: closed), and to the two planes of given concentration.
struct Level {
    std::array<int, 3> n{};
    std::array<bool, 3> periodic{};
    std::size_t axis = 2;
    std::array<std::vector<float>, 3> face;   // to the next cell; of the last cell to the first where periodic, else 0
    std::array<std::vector<float>, 2> plane;  // of the cells at either plane; empty where the axis is periodic
    std::vector<float> x, b, scratch;

    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
    }
    [[nodiscard]] std::array<std::size_t, 3> strides() const {
        return {1, static_cast<std::size_t>(n[0]), static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1])};
    }
    [[nodiscard]] std::array<int, 3> place(std::size_t i) const {
        const auto nx = static_cast<std::size_t>(n[0]), ny = static_cast<std::size_t>(n[1]);
        return {static_cast<int>(i % nx), static_cast<int>(i / nx % ny), static_cast<int>(i / (nx * ny))};
    }
    [[nodiscard]] std::size_t plane_index(const std::array<int, 3>& at) const {
        const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        return static_cast<std::size_t>(at[v]) * static_cast<std::size_t>(n[u]) + static_cast<std::size_t>(at[u]);
    }
    [[nodiscard]] std::size_t plane_size() const { return size() / static_cast<std::size_t>(n[axis]); }
};

// visit(cell, sum of its conductances, sum over neighbours of conductance times value) for all cells of one layer in z.
template <typename Value, typename Visit>
void for_layer(const Level& level, int k, const Value& value, const Visit& visit) {
    const auto stride = level.strides();
    std::array<int, 3> at{0, 0, k};
    for (at[1] = 0; at[1] < level.n[1]; ++at[1]) {
        std::size_t i = static_cast<std::size_t>(k) * stride[2] + static_cast<std::size_t>(at[1]) * stride[1];
        for (at[0] = 0; at[0] < level.n[0]; ++at[0], ++i) {
            double diagonal = 0.0, around = 0.0;
            for (std::size_t a = 0; a < 3; ++a) {
                const std::size_t around_the_box = stride[a] * static_cast<std::size_t>(level.n[a] - 1);
                if (const float g = level.face[a][i]; g > 0.0F) {
                    const std::size_t next = at[a] + 1 < level.n[a] ? i + stride[a] : i - around_the_box;
                    diagonal += static_cast<double>(g);
                    around += static_cast<double>(g) * static_cast<double>(value[next]);
                }
                if (at[a] == 0 && !level.periodic[a]) continue;
                const std::size_t previous = at[a] > 0 ? i - stride[a] : i + around_the_box;
                if (const float g = level.face[a][previous]; g > 0.0F) {
                    diagonal += static_cast<double>(g);
                    around += static_cast<double>(g) * static_cast<double>(value[previous]);
                }
            }
            if (!level.plane[0].empty()) {
                if (at[level.axis] == 0) diagonal += static_cast<double>(level.plane[0][level.plane_index(at)]);
                if (at[level.axis] + 1 == level.n[level.axis]) diagonal += static_cast<double>(level.plane[1][level.plane_index(at)]);
            }
            visit(i, diagonal, around);
        }
    }
}

// A grid of half as many cells a side. Joined cells count as one value; without the factor 1/2 the coarse grid would be twice too stiff.
Level coarser(const Level& fine) {
    Level level{.periodic = fine.periodic, .axis = fine.axis};
    for (std::size_t a = 0; a < 3; ++a) level.n[a] = (fine.n[a] + 1) / 2;
    for (auto& face : level.face) face.assign(level.size(), 0.0F);
    for (std::size_t end = 0; end < 2; ++end)
        if (!fine.plane[end].empty()) level.plane[end].assign(level.plane_size(), 0.0F);
    const auto stride = fine.strides();
    const auto coarse_stride = level.strides();
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
                    if (at[a] % 2 == 1 || at[a] + 1 == fine.n[a]) level.face[a][coarse] += 0.5F * fine.face[a][i];
                for (std::size_t end = 0; end < 2; ++end)
                    if (!fine.plane[end].empty() && at[fine.axis] == (end == 0 ? 0 : fine.n[fine.axis] - 1))
                        level.plane[end][level.plane_index({at[0] / 2, at[1] / 2, at[2] / 2})] +=
                            0.5F * fine.plane[end][fine.plane_index(at)];
            }
    // A cell is its own neighbour across a periodic side that is one cell wide.
    for (std::size_t a = 0; a < 3; ++a)
        if (level.n[a] == 1) level.face[a].assign(level.size(), 0.0F);
    level.x.resize(level.size());
    level.b.resize(level.size());
    level.scratch.resize(level.size());
    return level;
}

// Damped Jacobi sweeps; the result is in `x` again.
void smooth(Level& level, int sweeps, bool from_zero) {
    constexpr double damping = 0.8;
    for (int s = 0; s < sweeps; ++s) {
        const bool zero = from_zero && s == 0;
#pragma omp parallel for schedule(static)
        for (int k = 0; k < level.n[2]; ++k)
            for_layer(level, k, level.x, [&](std::size_t i, double diagonal, double around) {
                const double old = zero ? 0.0 : static_cast<double>(level.x[i]);
                const double sum = zero ? 0.0 : around;
                level.scratch[i] = diagonal > 0.0 ? static_cast<float>(old + damping * ((level.b[i] + sum) / diagonal - old)) : 0.0F;
            });
        level.x.swap(level.scratch);
    }
}

void cycle(std::vector<Level>& levels, std::size_t l) {
    Level& fine = levels[l];
    if (l + 1 == levels.size()) {
        smooth(fine, 40, true);
        return;
    }
    smooth(fine, 2, true);
    Level& coarse = levels[l + 1];
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
    cycle(levels, l + 1);
    const auto layer = static_cast<std::size_t>(fine.n[0]) * static_cast<std::size_t>(fine.n[1]);
#pragma omp parallel for schedule(static)
    for (int k = 0; k < fine.n[2]; ++k)
        for (std::size_t i = static_cast<std::size_t>(k) * layer; i < static_cast<std::size_t>(k + 1) * layer; ++i)
            fine.x[i] += coarse.x[coarse_of(i)];
    smooth(fine, 2, false);
}

// Sums that do not depend on the number of threads.
template <typename Term>
double sum_over(const Level& level, const Term& term) {
    const auto layer = static_cast<std::size_t>(level.n[0]) * static_cast<std::size_t>(level.n[1]);
    std::vector<double> parts(static_cast<std::size_t>(level.n[2]), 0.0);
#pragma omp parallel for schedule(static)
    for (int k = 0; k < level.n[2]; ++k)
        for (std::size_t i = static_cast<std::size_t>(k) * layer; i < static_cast<std::size_t>(k + 1) * layer; ++i)
            parts[static_cast<std::size_t>(k)] += term(i);
    double sum = 0.0;
    for (const double part : parts) sum += part;
    return sum;
}

template <typename Work>
void for_cells(const Level& level, const Work& work) {
    const auto count = static_cast<std::ptrdiff_t>(level.size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < count; ++i) work(static_cast<std::size_t>(i));
}

// The pores that join both planes, or that go round a periodic axis and come back one period on; 1 where they are.
std::vector<std::uint8_t> flowing_pores(const PhaseImage& image, std::size_t axis, const std::array<bool, 3>& periodic) {
    const auto& n = image.grid.cells;
    const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(n[0]),
                                               static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1])};
    std::vector<std::uint8_t> kept(image.phase.size(), 0);
    constexpr std::uint8_t unseen = 255;
    std::vector<std::uint8_t> winding(image.phase.size(), unseen);  // periods gone along the axis, plus 100
    std::vector<std::size_t> cluster;
    for (std::size_t seed = 0; seed < image.phase.size(); ++seed) {
        if (image.phase[seed] != pore || winding[seed] != unseen) continue;
        const auto seed_along = static_cast<int>(seed / stride[axis] % static_cast<std::size_t>(n[axis]));
        if (!periodic[axis] && seed_along != 0) continue;  // all that matter begin at the first plane
        bool through = false;
        cluster = {seed};
        winding[seed] = 100;
        for (std::size_t head = 0; head < cluster.size(); ++head) {
            const std::size_t i = cluster[head];
            for (std::size_t a = 0; a < 3; ++a) {
                const auto at = static_cast<int>(i / stride[a] % static_cast<std::size_t>(n[a]));
                for (const int step : {-1, 1}) {
                    int there = at + step;
                    std::uint8_t periods = winding[i];
                    if (there < 0 || there >= n[a]) {
                        through = through || (a == axis && !periodic[axis] && step > 0);
                        if (!periodic[a]) continue;
                        if (a == axis) periods = static_cast<std::uint8_t>(std::clamp(periods + step, 1, 200));
                        there = (there + n[a]) % n[a];
                    }
                    const std::size_t j = i + stride[a] * static_cast<std::size_t>(there) - stride[a] * static_cast<std::size_t>(at);
                    if (image.phase[j] != pore) continue;
                    if (winding[j] == unseen) {
                        winding[j] = periods;
                        cluster.push_back(j);
                    } else if (periodic[axis] && winding[j] != periods) {
                        through = true;
                    }
                }
            }
        }
        if (through)
            for (const std::size_t i : cluster) kept[i] = 1;
    }
    return kept;
}

Level finest(const PhaseImage& image, const std::vector<std::uint8_t>& flowing, std::size_t axis, const std::array<bool, 3>& periodic) {
    Level level{.n = image.grid.cells, .periodic = periodic, .axis = axis};
    const auto stride = level.strides();
    const auto& h = image.grid.spacing_m;
    const double scale = std::cbrt(h[0] * h[1] * h[2]);
    for (auto& face : level.face) face.assign(level.size(), 0.0F);
    for (std::size_t end = 0; end < 2; ++end)
        if (!periodic[axis]) level.plane[end].assign(level.plane_size(), 0.0F);
    std::array<int, 3> at{};
    for (at[2] = 0; at[2] < level.n[2]; ++at[2])
        for (at[1] = 0; at[1] < level.n[1]; ++at[1])
            for (at[0] = 0; at[0] < level.n[0]; ++at[0]) {
                const std::size_t i = image.grid.index(at[0], at[1], at[2]);
                if (flowing[i] == 0) continue;
                for (std::size_t a = 0; a < 3; ++a) {
                    const auto g = static_cast<float>(h[0] * h[1] * h[2] / (h[a] * h[a] * scale));
                    const bool last = at[a] + 1 == level.n[a];
                    if (a == axis && !periodic[a]) {
                        if (at[a] == 0) level.plane[0][level.plane_index(at)] = 2.0F * g;
                        if (last) level.plane[1][level.plane_index(at)] = 2.0F * g;
                    }
                    if ((last && !periodic[a]) || level.n[a] == 1) continue;
                    const std::size_t next = last ? i - stride[a] * static_cast<std::size_t>(level.n[a] - 1) : i + stride[a];
                    if (flowing[next] != 0) level.face[a][i] = g;
                }
            }
    level.x.resize(level.size());
    level.b.resize(level.size());
    level.scratch.resize(level.size());
    return level;
}

}  // namespace

double diffusive_memory_bytes(double cells) {
    return 60.0 * cells;
}

DiffusiveResult diffusive_tortuosity(const PhaseImage& image, int along, std::array<bool, 3> periodic, double tolerance,
                                     long most_iterations) {
    const auto axis = static_cast<std::size_t>(along);
    DiffusiveResult result;
    double inside = 0.0, pores = 0.0;
    for (const std::uint8_t phase : image.phase) {
        inside += phase != outside ? 1.0 : 0.0;
        pores += phase == pore ? 1.0 : 0.0;
    }
    std::vector<Level> levels;
    double flowing_cells = 0.0;
    {
        const std::vector<std::uint8_t> flowing = flowing_pores(image, axis, periodic);
        for (const std::uint8_t cell : flowing) flowing_cells += cell;
        if (flowing_cells == 0.0)
            throw DoesNotPercolate("no pores lead through: the section does not percolate", {.mend = "take finer voxels if it should"});
        levels.push_back(finest(image, flowing, axis, periodic));
    }
    result.porosity = pores / inside;
    result.porosity_flowing = flowing_cells / inside;
    while (levels.size() < 12 && *std::max_element(levels.back().n.begin(), levels.back().n.end()) > 6)
        levels.push_back(coarser(levels.back()));

    Level& fine = levels.front();
    const auto stride = fine.strides();
    const auto& h = image.grid.spacing_m;
    const double g_axis = h[0] * h[1] * h[2] / (h[axis] * h[axis] * std::cbrt(h[0] * h[1] * h[2]));
    const int layers = fine.n[axis];
    const bool around = periodic[axis];
    const auto along_of = [&](std::size_t i) { return static_cast<int>(i / stride[axis] % static_cast<std::size_t>(layers)); };
    const auto previous = [&](std::size_t i) {
        return along_of(i) > 0 ? i - stride[axis] : i + stride[axis] * static_cast<std::size_t>(layers - 1);
    };
    // Between planes: concentration 1 at the first, 0 at the last. Periodic: a mean gradient of one unit a layer, of which x is the rest.
    std::vector<double> x(fine.size(), 0.0), r(fine.size(), 0.0), p(fine.size(), 0.0), q(fine.size(), 0.0);
    const auto multiply = [&](const std::vector<double>& in, const auto& put) {
#pragma omp parallel for schedule(static)
        for (int k = 0; k < fine.n[2]; ++k)
            for_layer(fine, k, in, [&](std::size_t i, double diagonal, double sum) { put(i, diagonal * in[i] - sum, diagonal); });
    };
    const auto source = [&](std::size_t i) {
        if (around) return static_cast<double>(fine.face[axis][i]) - static_cast<double>(fine.face[axis][previous(i)]);
        if (along_of(i) != 0) return 0.0;
        return static_cast<double>(fine.plane[0][fine.plane_index(fine.place(i))]);
    };
    if (!around) for_cells(fine, [&](std::size_t i) { x[i] = 1.0 - (along_of(i) + 0.5) / layers; });
    multiply(x, [&](std::size_t i, double product, double diagonal) {
        if (diagonal == 0.0) x[i] = 0.0;  // not a pore that leads through
        r[i] = diagonal > 0.0 ? source(i) - product : 0.0;
    });
    const double scale = std::sqrt(sum_over(fine, [&](std::size_t i) { return source(i) * source(i); }));
    const auto flux = [&](int end) {  // through the plane, or through all faces along the axis over the number of layers
        return sum_over(fine, [&](std::size_t i) {
            if (around) {
                const double g = static_cast<double>(fine.face[axis][i]);
                if (g == 0.0) return 0.0;
                const std::size_t next =
                    along_of(i) + 1 < layers ? i + stride[axis] : i - stride[axis] * static_cast<std::size_t>(layers - 1);
                return g * (1.0 + x[next] - x[i]) / layers;
            }
            if (along_of(i) != (end == 0 ? 0 : layers - 1)) return 0.0;
            const auto g = static_cast<double>(fine.plane[static_cast<std::size_t>(end)][fine.plane_index(fine.place(i))]);
            return g * (end == 0 ? 1.0 - x[i] : x[i]);
        });
    };
    Progress progress("tortuosity (diffusive)");
    double rho = 0.0, residual = scale > 0.0 ? std::sqrt(sum_over(fine, [&](std::size_t i) { return r[i] * r[i]; })) / scale : 0.0;
    const double first = residual;
    while (residual > tolerance && result.iterations < most_iterations) {
        check_interrupt();
        for_cells(fine, [&](std::size_t i) { fine.b[i] = static_cast<float>(r[i]); });
        cycle(levels, 0);
        const double now = sum_over(fine, [&](std::size_t i) { return r[i] * static_cast<double>(fine.x[i]); });
        const double beta = result.iterations == 0 ? 0.0 : now / rho;
        rho = now;
        for_cells(fine, [&](std::size_t i) { p[i] = static_cast<double>(fine.x[i]) + beta * p[i]; });
        multiply(p, [&](std::size_t i, double product, double) { q[i] = product; });
        const double alpha = rho / sum_over(fine, [&](std::size_t i) { return p[i] * q[i]; });
        for_cells(fine, [&](std::size_t i) {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
        });
        residual = std::sqrt(sum_over(fine, [&](std::size_t i) { return r[i] * r[i]; })) / scale;
        ++result.iterations;
        if (!std::isfinite(residual)) break;
        progress.update(std::log(first / residual) / std::log(first / tolerance), fmt::format("residual {:.1e}", residual));
    }
    result.residual = residual;
    result.converged = residual <= tolerance;
    if (!result.converged)
        throw NumericalError(fmt::format("diffusion has not converged: residual {:.2e} after {} iterations", residual, result.iterations),
                             {.allowed = fmt::format("{:.1e}", tolerance)});
    const double in = flux(0), out = around ? in : flux(1);
    result.flux_imbalance = std::abs(in - out) / in;
    // Without grains: g_axis for each cell of a layer, over the layers between the planes, or for one unit a layer.
    const double cells_a_layer = inside / layers;
    result.relative_diffusivity = 0.5 * (in + out) / (g_axis * cells_a_layer / (around ? 1.0 : layers));
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

}  // namespace porepack
