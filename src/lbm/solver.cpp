#include "lbm/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"

namespace porepack::lbm {
using namespace core;
using namespace converters;
namespace {

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
            const auto layer = static_cast<int>(domain.layer_of(node));
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

// The pressure along the bed is the slowest mode of a long bed: mass must move from layer to layer until all flow rates are equal. The
// mass that accumulates in the layers gives the flow rates that are not steady yet; Darcy's law, with the relative conductance of the
// layers, gives the pressures that remove them, and they are added to the nodes. In the steady state nothing accumulates (flow rates may
// differ, because interpolated walls do not conserve mass exactly), so the steady state is not changed.
class LayerBalance {
public:
    LayerBalance(const Domain& domain, const Scheme& scheme, const FlowSection& section)
        : domain_(domain),
          viscosity_(scheme.viscosity_lu()),
          force_(scheme.force[static_cast<std::size_t>(domain.drive.axis)]),
          nodes_(domain.layer_conductance.size(), 0.0) {
        for (std::size_t node = 0; node < domain.nodes(); ++node) nodes_[domain.layer_of(node)] += 1.0;
        porosity_ = static_cast<double>(domain.nodes()) / (section.area_cells * static_cast<double>(nodes_.size()));
    }

    // Velocities follow the pressure within about 3 k/(porosity nu) steps: a correction that comes more often is smaller.
    // `density` is that of the layers at the last check, and becomes that after this correction.
    void correct(Flow& flow, const Layers& layers, double permeability, long steps, std::vector<double>& density) const {
        const std::vector<double> before = std::exchange(density, layers.density);
        if (before.empty() || !(permeability > 0.0)) return;
        const std::vector<double> unsteady = unsteady_flow(before, density, steps);
        const auto& conductance = domain_.layer_conductance;
        const std::size_t n = nodes_.size();
        double resistance = 0.0, weighted = 0.0, mean = 0.0;
        for (std::size_t l = 0; l < n; ++l) {
            resistance += 1.0 / conductance[l];
            weighted += unsteady[l] / conductance[l];
            mean += layers.flow[l] / static_cast<double>(n);
        }
        const double scale = mean * resistance / (force_ * static_cast<double>(n)),
                     share = std::min(0.7, static_cast<double>(steps) * porosity_ * viscosity_ / (3.0 * permeability));
        std::vector<double> added(n);
        double plane = 0.0;
        for (std::size_t l = 0; l < n; ++l) {
            const double step = -3.0 * share * (weighted / resistance - unsteady[l]) / (scale * conductance[l]);
            added[l] = plane + 0.5 * step;
            plane += step;
            density[l] += added[l];
        }
        add(flow, added);
    }

private:
    // Flow rate of each layer relative to the first plane, from the mass that its layers have gained.
    [[nodiscard]] std::vector<double> unsteady_flow(const std::vector<double>& before, const std::vector<double>& now, long steps) const {
        std::vector<double> flow(nodes_.size());
        double plane = 0.0;
        for (std::size_t l = 0; l < flow.size(); ++l) {
            const double gain = nodes_[l] * (now[l] - before[l]) / static_cast<double>(steps);
            flow[l] = plane - 0.5 * gain;
            plane -= gain;
        }
        // Differences from layer to layer decay by themselves, and a pressure per layer cannot remove those that alternate.
        for (int pass = 0; pass < smoothing; ++pass) {
            double last = flow.front();
            for (std::size_t l = 0; l < flow.size(); ++l) {
                const double here = flow[l], next = flow[std::min(l + 1, flow.size() - 1)];
                flow[l] = 0.25 * last + 0.5 * here + 0.25 * next;
                last = here;
            }
        }
        return flow;
    }

    void add(Flow& flow, const std::vector<double>& added) const {
#pragma omp parallel for schedule(static)
        for (std::size_t first = 0; first < domain_.nodes(); first += Flow::chunk) {
            std::array<double, Flow::chunk> of_nodes;
            const std::size_t count = std::min(Flow::chunk, domain_.nodes() - first);
            for (std::size_t i = 0; i < count; ++i) of_nodes[i] = added[domain_.layer_of(first + i)];
            flow.add_density(first, std::span(of_nodes).first(count));
        }
    }

    static constexpr int smoothing = 8;  // passes: over about four layers

    const Domain& domain_;
    double viscosity_, force_, porosity_ = 1.0;
    std::vector<double> nodes_;  // per layer
};

}  // namespace

Layers measure_layers(const Flow& flow, const Domain& domain) {
    const auto count = static_cast<std::size_t>(domain.grid.cells[static_cast<std::size_t>(domain.drive.axis)]);
    struct Sums {
        const Domain& domain;
        std::vector<double> flow, power, density, nodes;
        void visit(std::size_t node, const Moments& here) {
            const std::size_t layer = domain.layer_of(node);
            const double along = here.velocity[static_cast<std::size_t>(domain.drive.axis)];
            flow[layer] += along;
            power[layer] += along * here.density;
            density[layer] += here.density;
            nodes[layer] += 1.0;
        }
    };
    const std::vector<double> none(count, 0.0);
    Sums all{domain, none, none, none, none};
    for_all_moments(
        flow, domain.nodes(),
        [&] {
            return Sums{domain, none, none, none, none};
        },
        [&](const Sums& sums) {
            for (std::size_t k = 0; k < count; ++k) {
                all.flow[k] += sums.flow[k];
                all.power[k] += sums.power[k];
                all.density[k] += sums.density[k];
                all.nodes[k] += sums.nodes[k];
            }
        });
    for (std::size_t k = 0; k < count; ++k) all.density[k] /= std::max(1.0, all.nodes[k]);
    return {all.flow, all.power, all.density};
}

double gradient_between(double force, const Drive& drive, const Layers& layers, std::size_t first, std::size_t last,
                        PlanePressure pressure) {
    const std::size_t n = layers.flow.size();
    // On end planes the density is zero; inside, the pressure on a plane is that of the layers on both sides.
    const auto on_plane = [&](std::size_t plane) {
        if (drive.by_pressure() && (plane == 0 || plane == n)) return 0.0;
        const std::size_t before = (plane + n - 1) % n, behind = plane % n;
        const double flow = layers.flow[before] + layers.flow[behind];
        if (pressure == PlanePressure::flux_weighted && flow != 0.0) return (layers.power[before] + layers.power[behind]) / flow;
        return 0.5 * (layers.density[before] + layers.density[behind]);
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
    std::optional<LayerBalance> balance;
    if (criterion.balance && domain.drive.by_pressure() && force != 0.0 && !scheme.inertia) balance.emplace(domain, scheme, section);
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
        run.gradient_lu = gradient_between(force, domain.drive, run.layers, first, last);
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
        if (passed < 2 && balance) balance->correct(flow, run.layers, run.permeability_lu, steps_per_check, run.layer_density);
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
