#include "lbm/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "lbm/lattice.hpp"

namespace porepack {

using d3q19::c;

StokesSolver::StokesSolver(const Domain& domain, const Relaxation& relaxation) : domain_(domain), relaxation_(relaxation) {
    const std::size_t n = domain.nodes();
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
    const double length = domain.grid.cells[axis];
    const std::size_t slots = domain.populations() + domain.open_links.size();
    now_.resize(slots);
    next_.resize(slots);
    const bool by_pressure = domain.drive.by_pressure();
    if (!by_pressure) force_[axis] = 1e-3;
    const std::size_t layer = static_cast<std::size_t>(domain.grid.cells[0]) * static_cast<std::size_t>(domain.grid.cells[1]);
#pragma omp parallel for schedule(static)
    for (std::size_t node = 0; node < n; ++node) {
        const double z = static_cast<double>(static_cast<std::size_t>(domain.cell[node]) / layer) + 0.5;
        const double density = by_pressure ? 1.0 - z / length : 0.0;
        for (std::size_t q = 0; q < 19; ++q)
            next_[Domain::slot(q, node)] = now_[Domain::slot(q, node)] = d3q19::w(static_cast<int>(q)) * density;
    }
    fill_open_links();
}

double StokesSolver::bytes_per_node() const {
    const double bytes = 8.0 * static_cast<double>(now_.size() + next_.size()) + 4.0 * static_cast<double>(domain_.pull.size()) +
                         4.0 * static_cast<double>(domain_.cell.size());
    return bytes / static_cast<double>(domain_.nodes());
}

// Constant pressure and normal flow on a plane half a cell away, by an antisymmetric mirror image: density 1 at the inlet,
// 0 at the outlet.
void StokesSolver::fill_open_links() {
    const std::size_t first = domain_.populations();
    for (std::size_t l = 0; l < domain_.open_links.size(); ++l) {
        const auto& link = domain_.open_links[l];
        now_[first + l] = -now_[link.source] + (link.inlet ? 2.0 * link.weight : 0.0);
    }
}

void StokesSolver::gather(std::size_t node, std::array<double, 19>& f) const {
    for (std::size_t q = 0; q < 19; ++q) f[q] = now_[domain_.pull[Domain::slot(q, node)]];
}

namespace {

struct DensityAndMomentum {
    double density, jx, jy, jz;
};

DensityAndMomentum sum_up(const std::array<double, 19>& f) {
    return {f[0] + f[1] + f[2] + f[3] + f[4] + f[5] + f[6] + f[7] + f[8] + f[9] + f[10] + f[11] + f[12] + f[13] + f[14] + f[15] + f[16] +
                f[17] + f[18],
            f[1] - f[2] + f[7] - f[8] + f[9] - f[10] + f[11] - f[12] + f[13] - f[14],
            f[3] - f[4] + f[7] - f[8] - f[9] + f[10] + f[15] - f[16] + f[17] - f[18],
            f[5] - f[6] + f[11] - f[12] - f[13] + f[14] + f[15] - f[16] - f[17] + f[18]};
}

}  // namespace

namespace {

// Nodes are taken in blocks: gather, collide in registers (vectorised over the block), write in runs.
constexpr std::size_t block = Domain::block;
using Lane = std::array<double, block>;

struct Rates {
    double plus, minus;
    std::array<double, 3> force;
};

// Legend: f populations, rho density, j momentum, e+ = w rho, e- = 3 w c.j the symmetric and antisymmetric parts of the
// linear equilibrium, s+ and s- their relaxation rates, F the body force.
template <std::size_t q>
inline void relax_pair(std::array<Lane, 19>& f, const Lane& rho, const std::array<Lane, 3>& j, const Rates& rates) {
    constexpr double w = q < 7 ? d3q19::w_axis : d3q19::w_diagonal;
    constexpr double cx = c[q][0], cy = c[q][1], cz = c[q][2];
    const double cF = cx * rates.force[0] + cy * rates.force[1] + cz * rates.force[2];
#pragma omp simd
    for (std::size_t i = 0; i < block; ++i) {
        const double cj = cx * j[0][i] + cy * j[1][i] + cz * j[2][i];
        const double even = rates.plus * (0.5 * (f[q][i] + f[q + 1][i]) - w * rho[i]);
        const double odd = rates.minus * (0.5 * (f[q][i] - f[q + 1][i]) - 3.0 * w * cj) - 3.0 * w * cF;
        f[q][i] -= even + odd;
        f[q + 1][i] -= even - odd;
    }
}

template <std::size_t... pair>
inline void relax_pairs(std::array<Lane, 19>& f, const Lane& rho, const std::array<Lane, 3>& j, const Rates& rates,
                        std::index_sequence<pair...>) {
    (relax_pair<2 * pair + 1>(f, rho, j, rates), ...);
}

template <std::size_t q>
inline void add_moments(const std::array<Lane, 19>& f, Lane& rho, std::array<Lane, 3>& j) {
#pragma omp simd
    for (std::size_t i = 0; i < block; ++i) {
        const double sum = f[q][i] + f[q + 1][i], difference = f[q][i] - f[q + 1][i];
        rho[i] += sum;
        j[0][i] += static_cast<double>(c[q][0]) * difference;
        j[1][i] += static_cast<double>(c[q][1]) * difference;
        j[2][i] += static_cast<double>(c[q][2]) * difference;
    }
}

template <std::size_t... pair>
inline void sum_moments(const std::array<Lane, 19>& f, Lane& rho, std::array<Lane, 3>& j, std::index_sequence<pair...>) {
    (add_moments<2 * pair + 1>(f, rho, j), ...);
}

void collide(std::array<Lane, 19>& f, const Rates& rates) {
    Lane rho = f[0];
    std::array<Lane, 3> j{};
    sum_moments(f, rho, j, std::make_index_sequence<9>{});
#pragma omp simd
    for (std::size_t i = 0; i < block; ++i) f[0][i] -= rates.plus * (f[0][i] - d3q19::w_rest * rho[i]);
    relax_pairs(f, rho, j, rates, std::make_index_sequence<9>{});
}

}  // namespace

void StokesSolver::step() {
    const Rates rates{.plus = 1.0 / relaxation_.tau, .minus = 1.0 / (0.5 + relaxation_.magic / (relaxation_.tau - 0.5)), .force = force_};
    const double* from = now_.data();
    double* to = next_.data();
    const std::uint32_t* pull = domain_.pull.data();
#pragma omp parallel for schedule(static)
    for (std::size_t b = 0; b < domain_.blocks(); ++b) {
        const std::size_t first = b * 19 * block;
        alignas(64) std::array<Lane, 19> f;
        for (std::size_t q = 0; q < 19; ++q)
            for (std::size_t i = 0; i < block; ++i) f[q][i] = from[pull[first + q * block + i]];
        collide(f, rates);
        std::copy_n(f.front().data(), 19 * block, to + first);
    }
    now_.swap(next_);
    fill_open_links();
}

StokesSolver::Moments StokesSolver::moments(std::size_t node) const {
    std::array<double, 19> f{};
    gather(node, f);
    const auto [rho, jx, jy, jz] = sum_up(f);
    return {rho, {jx + 0.5 * force_[0], jy + 0.5 * force_[1], jz + 0.5 * force_[2]}};
}

namespace {

std::size_t layer_of(const Domain& domain, std::size_t node) {
    const auto cell = static_cast<std::size_t>(domain.cell[node]);
    const auto nx = static_cast<std::size_t>(domain.grid.cells[0]), ny = static_cast<std::size_t>(domain.grid.cells[1]);
    return domain.drive.axis == 0 ? cell % nx : domain.drive.axis == 1 ? cell / nx % ny : cell / (nx * ny);
}

}  // namespace

StokesSolver::Layers StokesSolver::layers() const {
    const auto axis = static_cast<std::size_t>(domain_.drive.axis);
    const auto count = static_cast<std::size_t>(domain_.grid.cells[axis]);
    Layers layers{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
    std::vector<double> nodes(count, 0.0);
#pragma omp parallel
    {
        std::vector<double> flow(count, 0.0), density(count, 0.0), own(count, 0.0);
#pragma omp for schedule(static) nowait
        for (std::size_t node = 0; node < domain_.nodes(); ++node) {
            const Moments here = moments(node);
            const std::size_t layer = layer_of(domain_, node);
            flow[layer] += here.velocity[axis];
            density[layer] += here.density;
            own[layer] += 1.0;
        }
#pragma omp critical
        for (std::size_t k = 0; k < count; ++k) {
            layers.flow[k] += flow[k];
            layers.density[k] += density[k];
            nodes[k] += own[k];
        }
    }
    for (std::size_t k = 0; k < count; ++k) layers.density[k] /= std::max(1.0, nodes[k]);
    return layers;
}

namespace {

// The change still to come, if the last three values approach their limit geometrically.
double remaining_change(const std::vector<ConvergencePoint>& history, double k) {
    if (history.size() < 2) return 1.0;
    const double last = k - history.back().permeability_lu;
    const double before = history.back().permeability_lu - history[history.size() - 2].permeability_lu;
    const double ratio = before == 0.0 ? 0.0 : std::abs(last / before);
    if (ratio >= 0.999) return 1.0;
    return std::abs(last) * std::max(1.0, ratio / (1.0 - ratio)) / std::abs(k);
}

// Driving gradient over the section: the force, or the drop of pressure c_s^2 rho between its planes. Where reservoirs lie
// beyond the planes, the pressure on a plane is the mean of the layers on both sides.
double gradient_over(const StokesSolver& solver, const Domain& domain, const StokesSolver::Layers& layers, std::size_t first,
                     std::size_t last) {
    if (!domain.drive.by_pressure()) return solver.force_lu();
    const double above = first == 0 ? 1.0 : 0.5 * (layers.density[first - 1] + layers.density[first]);
    const double below = last + 1 == layers.density.size() ? 0.0 : 0.5 * (layers.density[last] + layers.density[last + 1]);
    return (above - below) / (3.0 * static_cast<double>(last - first + 1));
}

double tortuosity_of(const StokesSolver& solver, const Domain& domain, const FlowSection& section) {
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
    double speed = 0.0, along = 0.0;
#pragma omp parallel for schedule(static) reduction(+ : speed, along)
    for (std::size_t node = 0; node < domain.nodes(); ++node) {
        const auto layer = static_cast<int>(layer_of(domain, node));
        if (layer < section.first_layer || layer > section.last_layer) continue;
        const auto u = solver.moments(node).velocity;
        speed += std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        along += u[axis];
    }
    return speed / along;
}

}  // namespace

StokesRun run_to_steady(StokesSolver& solver, const Domain& domain, const Relaxation& relaxation, const FlowSection& section,
                        const StokesGate& gate) {
    constexpr long steps_a_check = 40;
    StokesRun run;
    const Stopwatch watch;
    Progress progress("lattice Boltzmann");
    const auto first = static_cast<std::size_t>(section.first_layer), last = static_cast<std::size_t>(section.last_layer);
    int passed = 0;
    while (run.steps < gate.max_steps && passed < 2) {
        check_interrupt();
        const long steps = std::min(steps_a_check, gate.max_steps - run.steps);
        for (long s = 0; s < steps; ++s) solver.step();
        run.steps += steps;
        const auto layers = solver.layers();
        const auto& flow = layers.flow;
        double sum = 0.0, low = 1e300, high = -1e300;
        for (std::size_t layer = first; layer <= last; ++layer) {
            sum += flow[layer];
            low = std::min(low, flow[layer]);
            high = std::max(high, flow[layer]);
        }
        const double mean = sum / static_cast<double>(last - first + 1);
        if (!std::isfinite(sum))
            throw NumericalError(fmt::format("the flow diverged within {} steps", run.steps),
                                 {.mend = "choose relaxation_time between 0.55 and 2"});
        run.gradient_lu = gradient_over(solver, domain, layers, first, last);
        const double darcy = relaxation.viscosity_lu() / (section.area_cells * run.gradient_lu);
        run.permeability_volume_lu = mean * darcy;
        run.permeability_lu = domain.drive.by_pressure() ? 0.5 * (flow[first] + flow[last]) * darcy : run.permeability_volume_lu;
        run.superficial_velocity_lu = mean / section.area_cells;
        run.flow_imbalance = (high - low) / std::abs(mean);
        run.iteration_error = remaining_change(run.history, run.permeability_volume_lu);
        run.history.push_back({run.steps, run.permeability_volume_lu, run.iteration_error, run.flow_imbalance});
        passed = run.iteration_error < gate.tolerance && run.flow_imbalance < gate.tolerance && mean > 0.0 ? passed + 1 : 0;
        const double worst = std::max(run.iteration_error, run.flow_imbalance);
        progress.update(std::clamp(std::log(worst) / std::log(gate.tolerance), 0.0, 1.0),
                        fmt::format("step {}, error {:.1e}", run.steps, worst));
    }
    run.converged = passed >= 2;
    run.seconds = watch.seconds();
    run.updates_per_second = static_cast<double>(run.steps) * static_cast<double>(domain.nodes()) / run.seconds;
    run.hydraulic_tortuosity = tortuosity_of(solver, domain, section);
    return run;
}

}  // namespace porepack
