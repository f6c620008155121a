#include "lbm/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "lbm/layer_balance.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

// Hydraulic tortuosity and kinetic energy of the section, and the sum of all velocities.
void measure_velocities(const Flow& flow, const Domain& domain, const FlowSection& section, StokesRun& run) {
    const FlowSums sums = flow.sums(domain, section.first_layer, section.last_layer);
    run.velocity_sum_lu = sums.velocity;
    run.hydraulic_tortuosity = sums.speed / sums.along;
    run.kinetic_energy_factor = sums.squares * sums.nodes / (sums.along * sums.along);
}

// k and everything else that a check computes, from the layers now and `apart` steps before.
void check(StokesRun& run, const Layers& before, long apart, const Domain& domain, const Scheme& scheme, const FlowSection& section,
           long min_steps) {
    const auto first = static_cast<std::size_t>(section.first_layer), last = static_cast<std::size_t>(section.last_layer);
    const Drive& drive = domain.drive;
    const double force = scheme.force[static_cast<std::size_t>(drive.axis)];
    double sum = 0.0, low = 1e300, high = -1e300;
    for (std::size_t layer = first; layer <= last; ++layer) {
        sum += run.layers.flow[layer];
        low = std::min(low, run.layers.flow[layer]);
        high = std::max(high, run.layers.flow[layer]);
    }
    const double mean = sum / static_cast<double>(last - first + 1);
    run.gradient_lu = gradient_between(force, drive, run.layers, first, last);
    const double darcy = scheme.viscosity_lu() / (section.area_cells * run.gradient_lu);
    run.permeability_volume_lu = mean * darcy;
    run.permeability_lu = drive.by_pressure() ? 0.5 * (run.layers.flow[first] + run.layers.flow[last]) * darcy : run.permeability_volume_lu;
    run.superficial_velocity_lu = mean / section.area_cells;
    run.flow_imbalance = (high - low) / std::abs(mean);
    const Unsteadiness rest =
        scheme.inertia() ? Unsteadiness{} : unsteadiness(drive, section, before, run.layers, apart, force, run.gradient_lu);
    run.history.push_back({.step = run.steps,
                           .permeability_lu = run.permeability_lu,
                           .permeability_volume_lu = run.permeability_volume_lu,
                           .expected_lu = rest.expected(run.permeability_lu),
                           .expected_volume_lu = rest.expected_volume(run.permeability_volume_lu),
                           .flow_imbalance = run.flow_imbalance});
    const double estimate = !scheme.inertia()       ? iteration_error(run.history)
                            : run.steps < min_steps ? 1.0
                                                    : iteration_error_with_inertia(run.history);
    run.history.back().iteration_error = estimate;
    run.iteration_error = estimate + drift_per_imbalance * run.flow_imbalance;
    if (!drive.by_pressure() && force != 0.0) {
        const double drop = 3.0 * force * static_cast<double>(domain.layers());
        run.mass_leak = (mean_density(run.layers.nodes, run.layers.density) - mean_density(before.nodes, before.density)) /
                        (static_cast<double>(apart) * drop);
    }
}

// A flow that has just been made, not one that starts from a coarser grid.
bool is_at_rest(const Layers& layers) {
    return std::all_of(layers.density.begin(), layers.density.end(), [](double density) { return density == 0.0; });
}

// The last two checks meet the tolerance.
bool is_steady(const std::vector<ConvergencePoint>& history, double tolerance) {
    const auto met = [&](const ConvergencePoint& point) { return point.iteration_error < tolerance && point.permeability_lu > 0.0; };
    return history.size() >= 2 && met(history.back()) && met(history[history.size() - 2]);
}

}  // namespace

StokesRun run_to_steady(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                        const ConvergenceCriterion& criterion, StokesRun run) {
    const long steps_per_check = criterion.steps_per_check;
    const Stopwatch watch;
    const auto seconds = [&] { return agreed(*domain.slabs, watch.seconds()); };
    const double seconds_before = run.seconds;
    const long steps_before = run.steps;
    std::optional<Progress> line;
    if (!criterion.progress) line.emplace("lattice Boltzmann");
    const auto progress = criterion.progress ? criterion.progress : [&line](long, std::optional<double> share, std::string_view detail) {
        line->update(share, detail);
    };
    const double force = scheme.force[static_cast<std::size_t>(domain.drive.axis)];
    const LayerBalance balance(domain, scheme, section.area_cells, criterion.balance);
    if (run.steps == 0 && is_at_rest(flow.layers(domain))) balance.begin(flow);
    // One process stops at any step; several agree to stop, at the checks.
    const auto stops = [&] { return domain.slabs->parts() == 1 && interrupted(); };
    constexpr long apart = 2;  // steps between the two states of a check
    double momentum_bound = 0.0;
    run.converged = is_steady(run.history, criterion.tolerance);
    while (run.steps < criterion.max_steps && !run.converged && run.seconds - seconds_before < criterion.max_seconds) {
        const long until = std::min((run.steps / steps_per_check + 1) * steps_per_check, criterion.max_steps + criterion.max_steps % 2);
        for (; run.steps < until - apart && !stops(); run.steps += 2) flow.advance_two_steps();
        const Layers before = flow.layers(domain);
        for (; run.steps < until && !stops(); run.steps += 2) flow.advance_two_steps();
        run.seconds = seconds_before + seconds();
        if (run.steps < until) {
            if (criterion.checkpoint) criterion.checkpoint(run, true);
            check_interrupt();
        }
        run.layers = flow.layers(domain);
        const double sum = std::accumulate(run.layers.flow.begin(), run.layers.flow.end(), 0.0);
        // The force cannot produce more momentum than this; a flow with more is an artefact of the scheme.
        const double gain = force * static_cast<double>(steps_per_check) * static_cast<double>(domain.all_nodes);
        if (momentum_bound == 0.0) momentum_bound = 10.0 * std::abs(sum);
        momentum_bound += 2.0 * gain;
        if (!std::isfinite(sum) || (force != 0.0 && std::abs(sum) > momentum_bound))
            throw FlowDiverged(fmt::format("the flow diverged within {} steps", run.steps),
                               {.fix = "choose relaxation_time between 0.55 and 2"});
        check(run, before, apart, domain, scheme, section, criterion.min_steps);
        run.converged = is_steady(run.history, criterion.tolerance);
        if (criterion.stop_when_growing && !run.converged && grows(run.history, criterion.tolerance))
            throw FlowDiverged(fmt::format("the flow grows instead of becoming steady, at step {}", run.steps),
                               {.fix = "choose relaxation_time between 0.55 and 1.5"});
        const double error = run.history.back().iteration_error;
        progress(run.steps, share_of_steps(run.history, criterion.tolerance), fmt::format("step {}, error {:.1e}", run.steps, error));
        if (!run.converged) balance.correct(flow, run.layers, run.permeability_lu, steps_per_check, run.balance);
        if (!run.converged) {
            const bool ends = any_of(*domain.slabs, interrupted());
            if (criterion.checkpoint) criterion.checkpoint(run, ends);
            if (ends) throw Interrupted();
        }
    }
    run.seconds = seconds_before + seconds();
    run.updates_per_second =
        static_cast<double>(run.steps - steps_before) * static_cast<double>(domain.all_nodes) / std::max(1e-9, watch.seconds());
    measure_velocities(flow, domain, section, run);
    return run;
}

}  // namespace porepack::lbm
