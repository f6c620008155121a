#include "lbm/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"

namespace porepack::lbm {
using namespace core;
namespace {

std::size_t layer_of(const Domain& domain, std::size_t node) {
    const auto cell = static_cast<std::size_t>(domain.cell[node]);
    const auto nx = static_cast<std::size_t>(domain.grid.cells[0]), ny = static_cast<std::size_t>(domain.grid.cells[1]);
    return domain.drive.axis == 0 ? cell % nx : domain.drive.axis == 1 ? cell / nx % ny : cell / (nx * ny);
}

// visit(node, moments) over all nodes; each thread has its own visitor, created by `make` and passed to `finish`.
template <typename Make, typename Finish>
void for_all_moments(const Flow& flow, std::size_t nodes, const Make& make, const Finish& finish) {
#pragma omp parallel
    {
        auto visitor = make();
        std::array<Moments, Flow::chunk> moments;
#pragma omp for schedule(static) nowait
        for (std::size_t first = 0; first < nodes; first += Flow::chunk) {
            const std::size_t count = std::min(Flow::chunk, nodes - first);
            flow.moments(first, std::span(moments).first(count));
            for (std::size_t i = 0; i < count; ++i) visitor.visit(first + i, moments[i]);
        }
#pragma omp critical(porepack_moments)
        finish(visitor);
    }
}

// The remaining change, if the values approach their limit geometrically; from the last two fifths of the history, so that
// a slow mode is detected among the fast ones.
double remaining_change(const std::vector<ConvergencePoint>& history, double ConvergencePoint::*value) {
    const std::size_t n = history.size(), apart = std::max<std::size_t>(1, n / 5);
    if (n < 2 * apart + 1) return 1.0;
    const double now = history[n - 1].*value, last = history[n - 1 - apart].*value, before = history[n - 1 - 2 * apart].*value;
    const double change = now - last, change_before = last - before;
    const double ratio = change_before == 0.0 ? 0.0 : std::abs(change / change_before);
    if (ratio >= 0.999) return 1.0;
    return std::abs(change) * std::max(1.0, ratio / (1.0 - ratio)) / std::abs(now);
}

// Hydraulic tortuosity of the section, and the sum of all velocities.
void measure_velocities(const Flow& flow, const Domain& domain, const FlowSection& section, StokesRun& run) {
    struct Sums {
        const Domain& domain;
        const FlowSection& section;
        double speed = 0.0, along = 0.0;
        std::array<double, 3> velocity{};
        void visit(std::size_t node, const Moments& here) {
            const auto& u = here.velocity;
            for (std::size_t a = 0; a < 3; ++a) velocity[a] += u[a];
            const auto layer = static_cast<int>(layer_of(domain, node));
            if (layer < section.first_layer || layer > section.last_layer) return;
            speed += std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            along += u[static_cast<std::size_t>(domain.drive.axis)];
        }
    };
    double speed = 0.0, along = 0.0;
    run.velocity_sum_lu = {0, 0, 0};
    for_all_moments(
        flow, domain.nodes(),
        [&] {
            return Sums{domain, section};
        },
        [&](const Sums& sums) {
            speed += sums.speed;
            along += sums.along;
            for (std::size_t a = 0; a < 3; ++a) run.velocity_sum_lu[a] += sums.velocity[a];
        });
    run.hydraulic_tortuosity = speed / along;
}

}  // namespace

Layers measure_layers(const Flow& flow, const Domain& domain) {
    const auto count = static_cast<std::size_t>(domain.grid.cells[static_cast<std::size_t>(domain.drive.axis)]);
    struct Sums {
        const Domain& domain;
        std::vector<double> flow, density, nodes;
        void visit(std::size_t node, const Moments& here) {
            const std::size_t layer = layer_of(domain, node);
            flow[layer] += here.velocity[static_cast<std::size_t>(domain.drive.axis)];
            density[layer] += here.density;
            nodes[layer] += 1.0;
        }
    };
    const std::vector<double> none(count, 0.0);
    Sums all{domain, none, none, none};
    for_all_moments(
        flow, domain.nodes(),
        [&] {
            return Sums{domain, none, none, none};
        },
        [&](const Sums& sums) {
            for (std::size_t k = 0; k < count; ++k) {
                all.flow[k] += sums.flow[k];
                all.density[k] += sums.density[k];
                all.nodes[k] += sums.nodes[k];
            }
        });
    for (std::size_t k = 0; k < count; ++k) all.density[k] /= std::max(1.0, all.nodes[k]);
    return {all.flow, all.density};
}

double gradient_between(double force, const Domain& domain, const Layers& layers, std::size_t first, std::size_t last) {
    const auto& density = layers.density;
    const std::size_t n = density.size();
    // On end planes the density is zero; inside the pressure on a plane is the mean of the layers on both sides.
    const auto on_plane = [&](std::size_t plane) {
        if (plane > 0 && plane < n) return 0.5 * (density[plane - 1] + density[plane]);
        return domain.drive.by_pressure() ? 0.0 : 0.5 * (density.front() + density.back());
    };
    return force + (on_plane(first) - on_plane(last + 1)) / (3.0 * static_cast<double>(last - first + 1));
}

StokesRun run_to_steady(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                        const ConvergenceCriterion& criterion, StokesRun run) {
    const long steps_per_check = criterion.steps_per_check;
    const Stopwatch watch;
    const double seconds_before = run.seconds;
    const long steps_before = run.steps;
    Progress progress("lattice Boltzmann");
    const auto first = static_cast<std::size_t>(section.first_layer), last = static_cast<std::size_t>(section.last_layer);
    const double force = scheme.force[static_cast<std::size_t>(domain.drive.axis)];
    double first_error = 0.0, momentum_bound = 0.0;
    int passed = 0;
    while (run.steps < criterion.max_steps && passed < 2 && watch.seconds() < criterion.max_seconds) {
        const long until = std::min((run.steps / steps_per_check + 1) * steps_per_check, criterion.max_steps + criterion.max_steps % 2);
        for (; run.steps < until && !interrupted(); run.steps += 2) flow.advance_two_steps();
        run.seconds = seconds_before + watch.seconds();
        if (run.steps < until && criterion.checkpoint) criterion.checkpoint(run);
        check_interrupt();
        run.layers = measure_layers(flow, domain);
        double sum = 0.0, low = 1e300, high = -1e300;
        for (std::size_t layer = first; layer <= last; ++layer) {
            sum += run.layers.flow[layer];
            low = std::min(low, run.layers.flow[layer]);
            high = std::max(high, run.layers.flow[layer]);
        }
        // The force cannot produce more momentum than this; a flow with more is an artefact of the scheme.
        const double gain = force * static_cast<double>(steps_per_check) * static_cast<double>(domain.nodes());
        if (momentum_bound == 0.0) momentum_bound = 10.0 * std::abs(sum);
        momentum_bound += 2.0 * gain;
        if (!std::isfinite(sum) || (force != 0.0 && std::abs(sum) > momentum_bound))
            throw NumericalError(fmt::format("the flow diverged within {} steps", run.steps),
                                 {.fix = "choose relaxation_time between 0.55 and 2"});
        const double mean = sum / static_cast<double>(last - first + 1);
        run.gradient_lu = gradient_between(force, domain, run.layers, first, last);
        const double darcy = scheme.viscosity_lu() / (section.area_cells * run.gradient_lu);
        run.permeability_volume_lu = mean * darcy;
        run.permeability_lu =
            domain.drive.by_pressure() ? 0.5 * (run.layers.flow[first] + run.layers.flow[last]) * darcy : run.permeability_volume_lu;
        run.superficial_velocity_lu = mean / section.area_cells;
        run.flow_imbalance = (high - low) / std::abs(mean);
        run.history.push_back({run.steps, run.permeability_lu, run.permeability_volume_lu, 1.0, run.flow_imbalance});
        run.iteration_error = std::max(remaining_change(run.history, &ConvergencePoint::permeability_lu),
                                       remaining_change(run.history, &ConvergencePoint::permeability_volume_lu));
        run.history.back().iteration_error = run.iteration_error;
        passed = run.iteration_error < criterion.tolerance && mean > 0.0 ? passed + 1 : 0;
        if (first_error == 0.0 || first_error == 1.0) first_error = run.iteration_error;
        progress.update(std::clamp(std::log(run.iteration_error / first_error) / std::log(criterion.tolerance / first_error), 0.0, 1.0),
                        fmt::format("step {}, error {:.1e}", run.steps, run.iteration_error));
        if (passed < 2 && criterion.checkpoint) criterion.checkpoint(run);
    }
    run.converged = passed >= 2;
    run.seconds = seconds_before + watch.seconds();
    run.updates_per_second =
        static_cast<double>(run.steps - steps_before) * static_cast<double>(domain.nodes()) / std::max(1e-9, watch.seconds());
    measure_velocities(flow, domain, section, run);
    return run;
}

}  // namespace porepack::lbm
