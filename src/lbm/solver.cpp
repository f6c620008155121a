#include "lbm/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"

namespace porepack {
namespace {

std::size_t layer_of(const Domain& domain, std::size_t node) {
    const auto cell = static_cast<std::size_t>(domain.cell[node]);
    const auto nx = static_cast<std::size_t>(domain.grid.cells[0]), ny = static_cast<std::size_t>(domain.grid.cells[1]);
    return domain.drive.axis == 0 ? cell % nx : domain.drive.axis == 1 ? cell / nx % ny : cell / (nx * ny);
}

// visit(node, moments) over all nodes; each thread has its own visitor, made by `make` and handed to `finish`.
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

// The change still to come, if the last three values approach their limit geometrically.
double remaining_change(double before_last, double last, double now) {
    const double change = now - last, change_before = last - before_last;
    const double ratio = change_before == 0.0 ? 0.0 : std::abs(change / change_before);
    if (ratio >= 0.999) return 1.0;
    return std::abs(change) * std::max(1.0, ratio / (1.0 - ratio)) / std::abs(now);
}

// Driving gradient over the section: the force, and where planes drive the flow what the rest of the pressure c_s^2 rho drops
// between the section's planes: none when they are the end planes, else the pressure on a plane is the mean of the layers on both sides.
double gradient_over(double force, const Domain& domain, const Layers& layers, std::size_t first, std::size_t last) {
    if (!domain.drive.by_pressure()) return force;
    const double above = first == 0 ? 0.0 : 0.5 * (layers.density[first - 1] + layers.density[first]);
    const double below = last + 1 == layers.density.size() ? 0.0 : 0.5 * (layers.density[last] + layers.density[last + 1]);
    return force + (above - below) / (3.0 * static_cast<double>(last - first + 1));
}

double tortuosity_of(const Flow& flow, const Domain& domain, const FlowSection& section) {
    struct Sums {
        const Domain& domain;
        const FlowSection& section;
        double speed = 0.0, along = 0.0;
        void visit(std::size_t node, const Moments& here) {
            const auto layer = static_cast<int>(layer_of(domain, node));
            if (layer < section.first_layer || layer > section.last_layer) return;
            const auto& u = here.velocity;
            speed += std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            along += u[static_cast<std::size_t>(domain.drive.axis)];
        }
    };
    double speed = 0.0, along = 0.0;
    for_all_moments(
        flow, domain.nodes(),
        [&] {
            return Sums{domain, section};
        },
        [&](const Sums& sums) {
            speed += sums.speed;
            along += sums.along;
        });
    return speed / along;
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

StokesRun run_to_steady(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowSection& section, const StokesGate& gate) {
    constexpr long steps_a_check = 40;
    StokesRun run;
    const Stopwatch watch;
    Progress progress("lattice Boltzmann");
    const auto first = static_cast<std::size_t>(section.first_layer), last = static_cast<std::size_t>(section.last_layer);
    const double force = scheme.force[static_cast<std::size_t>(domain.drive.axis)];
    std::array<double, 2> by_volume{}, by_flow{};  // of the last two checks
    int passed = 0;
    while (run.steps < gate.max_steps && passed < 2) {
        const long pairs = std::min(steps_a_check, gate.max_steps - run.steps + 1) / 2;
        for (long pair = 0; pair < pairs; ++pair) {
            check_interrupt();
            flow.advance_two_steps();
        }
        run.steps += 2 * pairs;
        const Layers layers = measure_layers(flow, domain);
        double sum = 0.0, low = 1e300, high = -1e300;
        for (std::size_t layer = first; layer <= last; ++layer) {
            sum += layers.flow[layer];
            low = std::min(low, layers.flow[layer]);
            high = std::max(high, layers.flow[layer]);
        }
        const double mean = sum / static_cast<double>(last - first + 1);
        if (!std::isfinite(sum))
            throw NumericalError(fmt::format("the flow diverged within {} steps", run.steps),
                                 {.mend = "choose relaxation_time between 0.55 and 2"});
        run.gradient_lu = gradient_over(force, domain, layers, first, last);
        const double darcy = scheme.viscosity_lu() / (section.area_cells * run.gradient_lu);
        run.permeability_volume_lu = mean * darcy;
        run.permeability_lu =
            domain.drive.by_pressure() ? 0.5 * (layers.flow[first] + layers.flow[last]) * darcy : run.permeability_volume_lu;
        run.superficial_velocity_lu = mean / section.area_cells;
        run.flow_imbalance = (high - low) / std::abs(mean);
        run.iteration_error = run.history.size() < 2 ? 1.0
                                                     : std::max(remaining_change(by_volume[0], by_volume[1], run.permeability_volume_lu),
                                                                remaining_change(by_flow[0], by_flow[1], run.permeability_lu));
        by_volume = {by_volume[1], run.permeability_volume_lu};
        by_flow = {by_flow[1], run.permeability_lu};
        run.history.push_back({run.steps, run.permeability_volume_lu, run.iteration_error, run.flow_imbalance});
        passed = run.iteration_error < gate.tolerance && mean > 0.0 ? passed + 1 : 0;
        progress.update(std::clamp(std::log(run.iteration_error) / std::log(gate.tolerance), 0.0, 1.0),
                        fmt::format("step {}, error {:.1e}", run.steps, run.iteration_error));
    }
    run.converged = passed >= 2;
    run.seconds = watch.seconds();
    run.updates_per_second = static_cast<double>(run.steps) * static_cast<double>(domain.nodes()) / run.seconds;
    run.hydraulic_tortuosity = tortuosity_of(flow, domain, section);
    return run;
}

}  // namespace porepack
