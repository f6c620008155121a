#include "lbm/inertia.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "lbm/mean_flow.hpp"
#include "lbm/pressure_ends.hpp"
#include "lbm/sequence.hpp"
#include "lbm/slabs.hpp"
#include "lbm/uses.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/walls.hpp"

namespace porepack::lbm {
namespace {

constexpr double largest_wall_error = 0.25;  // of means in time; the correction is known to a half of it
constexpr double fastest_allowed_lu = 0.1, slowest_viscosity_lu = 0.002, slowest_in_time_lu = 0.0008, creeping_viscosity_lu = 0.7 / 3.0;

// What a flow should be, in lattice units; its speed is the superficial velocity.
struct Wanted {
    double viscosity, force, speed;
    Model model;
};

// A computed flow, in lattice units: the next one starts from its fields.
struct Stored {
    std::vector<Moments> fields;
    double viscosity = 0.0, force = 0.0, speed = 0.0;
    double permeability = 0.0;  // by the resistance
};

class Series {
public:
    Series(const PoreSpace& space, double voxel_size_m, double length_m, const InertialCriterion& criterion, const Communicator& parts)
        : criterion_(criterion),
          in_situ_(space.ends == Ends::in_situ && !space.container.periodic()[2]),
          drive_(choose_drive(space.container, Axis::z)) {
        const CubicVoxels voxels = cubic_voxels(space, voxel_size_m, [&](const Grid& whole) {
            return SlabCuts(space, whole, parts).slab_of(whole, drive_.periodic[2], parts);
        });
        const std::optional<FlowWalls> walls = voxels.space.walls();
        domain_ = build_domain(voxels.image, drive_, walls ? &*walls : nullptr, 0.0, parts);
        section_ = flow_section(voxels.image.grid, voxels.space.container, voxels.space.section, drive_);
        stretch_ = voxels.stretch;
        length_ = length_m / voxel_size();
        stored_.fields.assign(domain_.nodes(), {});
        log_info("flow with inertia: {} x {} x {} voxels of {:.4g} m, {} fluid nodes", domain_.grid.cells[0], domain_.grid.cells[1],
                 domain_.grid.whole_cells(2), voxel_size(), nodes());
    }

    [[nodiscard]] double voxel_size() const { return domain_.grid.spacing_m[2]; }
    [[nodiscard]] std::size_t nodes() const { return static_cast<std::size_t>(domain_.all_nodes); }
    [[nodiscard]] std::optional<Stretch> stretch() const { return stretch_; }

    // From the fields of the stored flow; stores its own.
    StokesRun solve(const Wanted& wanted, double tolerance) {
        Scheme scheme{.tau = 0.5 + 3.0 * wanted.viscosity, .walls = Walls::interpolated, .model = wanted.model};
        const bool inertia = wanted.model == Model::navier_stokes;
        scheme.force[2] = wanted.force;
        std::unique_ptr<Flow> flow = start(Kernel::cpu_double, scheme);
        if (inertia && !domain_.boundary_links.empty()) flow = std::make_unique<PressureEnds>(std::move(flow), domain_);
        begin(*flow, wanted);
        StokesRun run = run_to_steady(*flow, domain_, scheme, section_,
                                      {.tolerance = tolerance,
                                       .max_steps = criterion_.max_steps,
                                       .steps_per_check = steps_per_check(wanted),
                                       .min_steps = inertia ? min_steps(wanted) : 0});
        // Drag of walls and grains per volume: of the deviation from the mean gradient, and the buoyancy of that gradient.
        // All of it belongs to the section, because free water has almost no resistance.
        const double layers = domain_.grid.whole_cells(2), volume = section_.area_cells * layers;
        gradient_ = wanted.force + (flow->drag(domain_)[2] - wanted.force * static_cast<double>(nodes())) / volume;
        const double evaluated = section_.last_layer - section_.first_layer + 1;
        resistance_ = gradient_ * layers / evaluated;
        if (in_situ_) {
            const auto first = static_cast<std::size_t>(section_.first_layer), last = static_cast<std::size_t>(section_.last_layer);
            const double gained = (kinetic_energy_on_plane(run.layers, first) - kinetic_energy_on_plane(run.layers, last + 1)) / evaluated;
            resistance_ = run.gradient_lu + (inertia ? gained : 0.0);
            kinetic_share_ = inertia ? gained / resistance_ : 0.0;
        }
        keep(*flow, wanted, run.superficial_velocity_lu);
        return run;
    }

    // The mean in time, in a cell that is periodic along the flow: there the mean drag balances the force.
    MeanFlow average(const Wanted& wanted) {
        const InertialCriterion::InTime& criterion = *criterion_.in_time;
        Scheme scheme{.tau = 0.5 + 3.0 * wanted.viscosity, .walls = Walls::interpolated, .model = wanted.model};
        scheme.force[2] = wanted.force;
        const std::unique_ptr<Flow> flow = start(Kernel::cpu_single, scheme);  // rounding is far below the statistical error
        disturb(stored_.speed);
        begin(*flow, wanted);
        MeanFlow mean = average_in_time(
            *flow, domain_, section_.area_cells,
            {.tolerance = criterion.tolerance, .turnover_steps = turnover_steps(wanted), .max_turnovers = criterion.max_turnovers});
        gradient_ = resistance_ = wanted.force;
        kinetic_share_ = 0.0;
        keep(*flow, wanted, mean.superficial_velocity_lu);
        return mean;
    }

    [[nodiscard]] const Stored& stored() const { return stored_; }
    void restore(Stored flow) { stored_ = std::move(flow); }

    [[nodiscard]] double length() const { return length_; }  // of the Reynolds numbers, in voxels
    // Pressure gradient of the section's resistance, and the mean over the whole image that balances the drag.
    [[nodiscard]] double resistance() const { return resistance_; }
    [[nodiscard]] double kinetic_share() const { return kinetic_share_; }
    [[nodiscard]] double gradient() const { return gradient_; }
    [[nodiscard]] double fastest() const {
        double maximum = 0.0;
        for (const Moments& node : stored_.fields) {
            const auto& u = node.velocity;
            maximum = std::max(maximum, u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        }
        return std::sqrt(largest_of(*domain_.slabs, maximum));
    }

private:
    std::unique_ptr<Flow> start(Kernel kernel, const Scheme& scheme) {
        std::shared_ptr<const FlowPlan>& plan = plans_[kernel];
        if (!plan)
            plan = criterion_.device ? plan_flow(criterion_.device, kernel == Kernel::cpu_single, domain_) : plan_flow(kernel, domain_);
        return plan->start(scheme);
    }
    // Waves across the cell, so that a symmetric flow can leave its symmetry.
    void disturb(double speed) {
        constexpr double share = 0.05;
        const Grid& grid = domain_.grid;
        std::size_t node = 0;
        domain_.cells.for_each([&](std::size_t cell) {
            auto at = grid.place(cell);
            at[2] = grid.layer(at[2]);
            auto& u = stored_.fields[node++].velocity;
            for (std::size_t a = 0; a < 3; ++a) {
                const std::size_t along = (a + 1) % 3;
                u[a] += share * speed *
                        std::sin(2.0 * std::numbers::pi * (at[along] + 0.3) / grid.whole_cells(along) + 1.0 + static_cast<double>(a));
            }
        });
    }
    // In proportion to the velocity and the force that it should have.
    void begin(Flow& flow, const Wanted& wanted) {
        if (stored_.speed > 0.0)
            for (Moments& node : stored_.fields) {
                node.density *= wanted.force / stored_.force;
                for (double& u : node.velocity) u *= wanted.speed / stored_.speed;
            }
        flow.set_moments(0, stored_.fields);
    }
    void keep(const Flow& flow, const Wanted& wanted, double speed) {
        flow.moments(0, stored_.fields);
        stored_.viscosity = wanted.viscosity;
        stored_.force = wanted.force;
        stored_.speed = speed;
        stored_.permeability = wanted.viscosity * speed / resistance_;
    }

    // Momentum relaxes within a time of k/nu.
    [[nodiscard]] long steps_per_check(const Wanted& wanted) const {
        return std::max(40L, 2 * std::lround(0.25 * stored_.permeability / wanted.viscosity));
    }
    // In which the mean velocity in the pores passes one length.
    [[nodiscard]] double turnover_steps(const Wanted& wanted) const {
        const double porosity = static_cast<double>(nodes()) / (section_.area_cells * domain_.grid.whole_cells(2));
        return length_ * porosity / wanted.speed;
    }
    // A flow first seems steady while what it brings along from the flow before has not yet been carried away.
    [[nodiscard]] long min_steps(const Wanted& wanted) const {
        const double viscous = length_ * length_ / wanted.viscosity;
        return std::lround(std::min(0.5 * turnover_steps(wanted), 0.03 * viscous));
    }

    InertialCriterion criterion_;
    bool in_situ_;
    Drive drive_;
    Domain domain_;
    FlowSection section_;
    std::optional<Stretch> stretch_;
    std::map<Kernel, std::shared_ptr<const FlowPlan>> plans_;
    double length_ = 0.0;
    Stored stored_;
    double gradient_ = 0.0, resistance_ = 0.0, kinetic_share_ = 0.0;
};

// 1/k grows about linearly, and at most in proportion to Re: what the flow at this Reynolds number should have, in lattice units.
double expected_resistance(const InertialSeries& known, double wanted) {
    const double h2 = known.voxel_size_m * known.voxel_size_m;
    const auto& flows = known.flows;
    if (flows.empty()) return h2 / known.creeping_permeability_m2;
    const InertialFlow& last = flows.back();
    const double before_re = flows.size() > 1 ? flows[flows.size() - 2].reynolds : 0.0,
                 before = h2 / (flows.size() > 1 ? flows[flows.size() - 2].permeability_m2 : known.creeping_permeability_m2);
    const double now = h2 / last.permeability_m2, slope = (now - before) / (last.reynolds - before_re);
    return std::clamp(now + slope * (wanted - last.reynolds), now, std::max(now, now * wanted / last.reynolds));
}

// solve(), with advice that fits a flow of a series.
StokesRun steady_flow(Series& series, const Wanted& wanted, double tolerance, const char* fix) {
    try {
        return series.solve(wanted, tolerance);
    } catch (const FlowDiverged& diverged) {
        throw NumericalError(diverged.fault(), {.fix = fix});
    }
}

// What the walls of the recursive collision do to k of creeping flow, relative to the steady scheme, at this viscosity (Re 0.001). The
// stored flow stays.
double wall_error(Series& series, const InertialSeries& known, double viscosity) {
    const double k_lu = known.creeping_permeability_m2 / (known.voxel_size_m * known.voxel_size_m),
                 speed = 1e-3 * viscosity / series.length();
    Stored before = series.stored();
    const StokesRun run =
        steady_flow(series, {.viscosity = viscosity, .force = viscosity * speed / k_lu, .speed = speed, .model = Model::recursive},
                    InertialFlow::InTime::wall_error_tolerance, "use smaller voxels or smaller Reynolds numbers");
    series.restore(std::move(before));
    if (!run.converged)
        throw NumericalError(fmt::format("creeping flow by the scheme of means in time is not steady after {} steps", run.steps),
                             {.fix = "raise max_steps, or use smaller Reynolds numbers"});
    const double error = run.permeability_lu / k_lu - 1.0;
    if (std::abs(error) > largest_wall_error)
        throw NumericalError(
            fmt::format("the walls of means in time change k by {:.0f} % on voxels of {:.3g} m", 100.0 * error, known.voxel_size_m),
            {.allowed = fmt::format("at most {:.0f} %", 100.0 * largest_wall_error),
             .fix = fmt::format("voxels of about {:.2g} m",
                                known.voxel_size_m * std::pow(0.8 * largest_wall_error / std::abs(error), 1.0 / 1.5))});
    return error;
}

struct Planned {
    double reynolds, viscosity;
};
// Those that this grid can resolve; else `known.stopped_by` says why.
std::vector<Planned> plan_flows(InertialSeries& known, bool in_time, std::span<const double> reynolds, double length_lu) {
    std::vector<Planned> plan;
    for (const double wanted : reynolds) {
        const double viscosity = std::min(creeping_viscosity_lu, fastest_allowed_lu / known.peak_over_mean * length_lu / wanted);
        if (viscosity < (in_time ? slowest_in_time_lu : slowest_viscosity_lu)) {
            known.stopped_by = fmt::format("Re {:g} needs smaller voxels than {:.4g} m", wanted, known.voxel_size_m);
            break;
        }
        plan.push_back({wanted, viscosity});
    }
    return plan;
}

// A mean in time, from the fields of `state`: by two relaxation times, whose walls are as accurate as those of steady flows, as long as
// they are stable; then by the recursive collision, with the error of its walls.
struct TimeAverage {
    MeanFlow mean;
    double walls = 0.0;
};
TimeAverage average(Series& series, const InertialSeries& known, Wanted wanted, bool& two_times_stable) {
    if (two_times_stable) {
        Stored before = series.stored();
        try {
            return {series.average(wanted)};
        } catch (const FlowDiverged&) {
            log_info("two relaxation times are not stable any more: a more stable collision, with less accurate walls, from here on");
            two_times_stable = false;
            series.restore(std::move(before));
        }
    }
    const double walls = wall_error(series, known, wanted.viscosity);
    wanted.force /= 1.0 + walls;
    wanted.model = Model::recursive;
    return {series.average(wanted), walls};
}

// The flow that should have the wanted Reynolds number.
InertialFlow next_flow(Series& series, const InertialSeries& known, const InertialCriterion& criterion, double reynolds, double viscosity,
                       bool& two_times_stable) {
    const double h2 = known.voxel_size_m * known.voxel_size_m, speed = reynolds * viscosity / series.length();
    const Wanted wanted{.viscosity = viscosity,
                        .force = viscosity * speed * expected_resistance(known, reynolds) * series.gradient() / series.resistance(),
                        .speed = speed,
                        .model = Model::navier_stokes};
    double walls = 0.0;
    InertialFlow flow{.relaxation_time = 0.5 + 3.0 * viscosity};
    if (criterion.in_time) {
        const TimeAverage found = average(series, known, wanted, two_times_stable);
        const MeanFlow& mean = found.mean;
        walls = found.walls;
        flow.converged = mean.converged;
        flow.fastest_lu = mean.fastest_lu;
        flow.in_time = {.steady = mean.steady,
                        .half_width = mean.half_width,
                        .fluctuation = mean.fluctuation,
                        .kinetic_energy_factor = mean.kinetic_energy_factor,
                        .lateral_share = mean.lateral_share,
                        .turnovers = mean.turnovers,
                        .correlation_turnovers = mean.correlation_turnovers,
                        .wall_error = walls};
        flow.steps = mean.steps;
        flow.seconds = mean.seconds;
        if (!flow.converged)
            throw NumericalError(
                fmt::format("the mean velocity is known to {:.2g} % only after {:.0f} turnovers", 100.0 * mean.half_width, mean.turnovers),
                {.fix = "raise forchheimer.max_turnovers, or accept less certain means with statistical_tolerance"});
    } else {
        StokesRun run =
            steady_flow(series, wanted, criterion.tolerance,
                        "use smaller voxels, or compute the flow's mean in time (forchheimer.mean_in_time) on a periodic packing");
        flow.iteration_error = run.iteration_error;
        flow.converged = run.converged;
        flow.fastest_lu = series.fastest();
        flow.steps = run.steps;
        flow.seconds = run.seconds;
        flow.history = std::move(run.history);
        if (!flow.converged)
            throw NumericalError(fmt::format("no steady flow within {} steps (iteration error {:.1e}, tolerance {:.1e})", run.steps,
                                             run.iteration_error, criterion.tolerance),
                                 {.fix = "compute the flow's mean in time (forchheimer.mean_in_time) on a periodic packing"});
    }
    const Stored& found = series.stored();
    flow.reynolds = found.speed * series.length() / viscosity;
    flow.permeability_m2 = found.permeability * h2 / (1.0 + walls);
    flow.momentum_share = 1.0 - series.gradient() / found.force;
    flow.kinetic_energy_share = series.kinetic_share();
    return flow;
}

}  // namespace

InertialSeries lbm_inertial_flows(const PoreSpace& space, double voxel_size_m, std::span<const double> reynolds, double length_m,
                                  const InertialCriterion& criterion, const Communicator& parts) {
    if (criterion.in_time && !space.container.periodic()[2])
        throw UserError("means in time need a box that is periodic along z: end planes would disturb a flow that is not steady",
                        {.fix = "leave mean_in_time out, or use a periodic packing"});
    Series series(space, voxel_size_m, length_m, criterion, parts);
    const double h = series.voxel_size();
    bool two_times_stable = criterion.in_time && criterion.in_time->accurate_while_stable;
    const StokesRun creeping =
        series.solve({.viscosity = creeping_viscosity_lu, .force = 1e-6, .speed = 0.0, .model = Model::stokes}, 0.1 * criterion.tolerance);
    if (!creeping.converged)
        throw NumericalError(fmt::format("creeping flow is not steady after {} steps; no permeability is given", creeping.steps),
                             {.fix = "raise max_steps"});
    InertialSeries result{.voxel_size_m = h,
                          .stretch = series.stretch(),
                          .nodes = series.nodes(),
                          .creeping_permeability_m2 = series.stored().permeability * h * h,
                          .peak_over_mean = series.fastest() / series.stored().speed,
                          .flows = {},
                          .stopped_by = {}};
    for (const auto& [wanted, viscosity] : plan_flows(result, criterion.in_time.has_value(), reynolds, series.length())) {
        try {
            const InertialFlow flow = next_flow(series, result, criterion, wanted, viscosity, two_times_stable);
            if (!result.flows.empty() && flow.reynolds <= result.flows.back().reynolds) {
                log_warning(fmt::format("the flow that should have Re {:g} has {:.4g}, no more than the one before: it is left out", wanted,
                                        flow.reynolds));
                continue;
            }
            result.flows.push_back(flow);
            log_info("lattice Boltzmann: Re {:.4g}: k = {:.5g} m2, {:.4f} of creeping flow, {} steps{}", flow.reynolds,
                     flow.permeability_m2, flow.permeability_m2 / result.creeping_permeability_m2, flow.steps,
                     flow.in_time && !flow.in_time->steady ? fmt::format(", velocity varies by {:.2g} %", 100.0 * flow.in_time->fluctuation)
                                                           : "");
        } catch (const NumericalError& fault) {
            result.stopped_by = fmt::format("Re {:g}: {}", wanted, fault.what());
            break;
        }
    }
    return result;
}

}  // namespace porepack::lbm
