#include "lbm/inertia.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "lbm/mean_flow.hpp"
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

// Constant pressure on the end planes: the incoming population is minus the outgoing one (which keeps p + u^2 constant) plus 6 w u^2 with
// the velocity normal to the plane, from two steps before.
class PressureEnds : public Flow {
public:
    PressureEnds(std::unique_ptr<Flow> flow, const Domain& domain) : flow_(std::move(flow)), domain_(domain) {
        for (const BoundaryLink& link : domain.boundary_links)
            for (const std::size_t node : {link.node, link.source}) chunks_.push_back(node / chunk);
        std::sort(chunks_.begin(), chunks_.end());
        chunks_.erase(std::unique(chunks_.begin(), chunks_.end()), chunks_.end());
        speed_.resize(chunks_.size() * chunk);
        const auto place = [&](std::size_t node) {
            const auto rank = std::lower_bound(chunks_.begin(), chunks_.end(), node / chunk) - chunks_.begin();
            return static_cast<std::size_t>(rank) * chunk + node % chunk;
        };
        for (const BoundaryLink& link : domain.boundary_links) places_.push_back({place(link.node), place(link.source)});
        added_.resize(domain.boundary_links.size());
    }
    void advance_two_steps() override {
        flow_->advance_two_steps();
        update();
    }
    void update() {
        for (std::size_t c = 0, end = 0; c < chunks_.size(); c = end) {
            for (end = c + 1; end < chunks_.size() && chunks_[end] == chunks_[end - 1] + 1;) ++end;
            const std::size_t first = chunks_[c] * chunk;
            moments_.resize(std::min((end - c) * chunk, domain_.nodes() - first));
            flow_->moments(first, moments_);
            for (std::size_t i = 0; i < moments_.size(); ++i) speed_[c * chunk + i] = moments_[i].velocity[2];
        }
        for (std::size_t l = 0; l < added_.size(); ++l) {
            const BoundaryLink& link = domain_.boundary_links[l];
            const double across = 0.5 * (speed_[places_[l][0]] + speed_[places_[l][1]]);
            const bool comes_back = across < 0.0 && d3q19::c[link.q][2] < 0;
            added_[l] = (comes_back ? 3.0 : 6.0) * d3q19::w(link.q) * across * across;
        }
        flow_->set_boundary_links(added_);
    }
    [[nodiscard]] Layers layers(const Domain& domain) const override { return flow_->layers(domain); }
    [[nodiscard]] FlowSums sums(const Domain& domain, int first_layer, int last_layer) const override {
        return flow_->sums(domain, first_layer, last_layer);
    }
    [[nodiscard]] std::array<double, 3> drag(const Domain& domain) const override { return flow_->drag(domain); }
    void add_to_layers(const Domain& domain, std::span<const double> added) override { flow_->add_to_layers(domain, added); }
    void moments(std::size_t first, std::span<Moments> moments) const override { flow_->moments(first, moments); }
    void wall_forces(std::size_t first, std::span<std::array<double, 3>> forces) const override { flow_->wall_forces(first, forces); }
    void set_moments(std::size_t first, std::span<const Moments> moments) override { flow_->set_moments(first, moments); }
    void set_boundary_links(std::span<const double> added) override { flow_->set_boundary_links(added); }
    void populations(std::size_t first, std::span<std::byte> of_nodes) const override { flow_->populations(first, of_nodes); }
    void set_populations(std::size_t first, std::span<const std::byte> of_nodes) override { flow_->set_populations(first, of_nodes); }
    [[nodiscard]] std::size_t bytes_per_number() const override { return flow_->bytes_per_number(); }
    void add_density(std::size_t first, std::span<const double> added) override { flow_->add_density(first, added); }
    [[nodiscard]] double bytes() const override { return flow_->bytes(); }

private:
    std::unique_ptr<Flow> flow_;
    const Domain& domain_;
    std::vector<Moments> moments_;  // of some chunks
    std::vector<double> added_;
    std::vector<std::size_t> chunks_;                 // with nodes at open ends, ascending
    std::vector<double> speed_;                       // of their nodes
    std::vector<std::array<std::size_t, 2>> places_;  // of each link's node and source in speed_
};

class Series {
public:
    Series(const PoreSpace& space, double voxel_size_m, const InertialCriterion& criterion, const Communicator& parts)
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
        moments_.assign(domain_.nodes(), {});
        log_info("flow with inertia: {} x {} x {} voxels of {:.4g} m, {} fluid nodes", domain_.grid.cells[0], domain_.grid.cells[1],
                 domain_.grid.whole_cells(2), voxel_size(), nodes());
    }

    [[nodiscard]] double voxel_size() const { return domain_.grid.spacing_m[2]; }
    [[nodiscard]] std::size_t nodes() const { return static_cast<std::size_t>(domain_.all_nodes); }
    [[nodiscard]] std::optional<Stretch> stretch() const { return stretch_; }

    // Starts from the moments of the previous flow, velocities times `faster` and densities times `denser`; stores its own moments.
    // Momentum relaxes within a time of k/nu.
    StokesRun solve(double viscosity, double force, Model model, double faster, double denser, double settling_steps) {
        Scheme scheme{.tau = 0.5 + 3.0 * viscosity, .walls = Walls::interpolated, .model = model};
        const bool inertia = model == Model::navier_stokes;
        scheme.force[2] = force;
        std::unique_ptr<Flow> flow = start(Kernel::cpu_double, scheme);
        if (inertia && !domain_.boundary_links.empty()) flow = std::make_unique<PressureEnds>(std::move(flow), domain_);
        begin(*flow, faster, denser);
        StokesRun run = run_to_steady(*flow, domain_, scheme, section_,
                                      {.tolerance = inertia ? criterion_.tolerance : 0.1 * criterion_.tolerance,
                                       .max_steps = criterion_.max_steps,
                                       .steps_per_check = std::max(40L, 2 * std::lround(0.25 * settling_steps))});
        // Drag of walls and grains per volume: of the deviation from the mean gradient, and the buoyancy of that gradient.
        // All of it belongs to the section, because free water has almost no resistance.
        const double layers = domain_.grid.whole_cells(2), volume = section_.area_cells * layers;
        gradient_ = force + (flow->drag(domain_)[2] - force * static_cast<double>(nodes())) / volume;
        const double evaluated = section_.last_layer - section_.first_layer + 1;
        resistance_ = gradient_ * layers / evaluated;
        if (in_situ_) {
            const auto first = static_cast<std::size_t>(section_.first_layer), last = static_cast<std::size_t>(section_.last_layer);
            const double gained = (kinetic_energy_on_plane(run.layers, first) - kinetic_energy_on_plane(run.layers, last + 1)) / evaluated;
            resistance_ = run.gradient_lu + (inertia ? gained : 0.0);
            kinetic_share_ = inertia ? gained / resistance_ : 0.0;
        }
        keep(*flow);
        return run;
    }

    // The mean in time, in a cell that is periodic along the flow: there the mean drag balances the force.
    MeanFlow average(double viscosity, double force, double wanted_speed, double length_lu, Model model, double faster, double denser) {
        const InertialCriterion::InTime& criterion = *criterion_.in_time;
        Scheme scheme{.tau = 0.5 + 3.0 * viscosity, .walls = Walls::interpolated, .model = model};
        scheme.force[2] = force;
        const std::unique_ptr<Flow> flow = start(Kernel::cpu_single, scheme);  // rounding is far below the statistical error
        disturb(wanted_speed / faster);
        begin(*flow, faster, denser);
        const double layers = domain_.grid.whole_cells(2), porosity = static_cast<double>(nodes()) / (section_.area_cells * layers);
        MeanFlow mean = average_in_time(*flow, domain_, section_.area_cells,
                                        {.tolerance = criterion.tolerance,
                                         .turnover_steps = length_lu * porosity / wanted_speed,
                                         .max_turnovers = criterion.max_turnovers});
        gradient_ = resistance_ = force;
        kinetic_share_ = 0.0;
        keep(*flow);
        return mean;
    }

    // Density and velocity of the nodes, from which the next flow starts.
    [[nodiscard]] const std::vector<Moments>& fields() const { return moments_; }
    void set_fields(std::vector<Moments> fields) { moments_ = std::move(fields); }

    // Pressure gradient of the section's resistance, and the mean over the whole image that balances the drag.
    [[nodiscard]] double resistance() const { return resistance_; }
    [[nodiscard]] double kinetic_share() const { return kinetic_share_; }
    [[nodiscard]] double gradient() const { return gradient_; }
    [[nodiscard]] double fastest() const {
        double maximum = 0.0;
        for (const Moments& node : moments_) {
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
            auto& u = moments_[node++].velocity;
            for (std::size_t a = 0; a < 3; ++a) {
                const std::size_t along = (a + 1) % 3;
                u[a] += share * speed *
                        std::sin(2.0 * std::numbers::pi * (at[along] + 0.3) / grid.whole_cells(along) + 1.0 + static_cast<double>(a));
            }
        });
    }
    void begin(Flow& flow, double faster, double denser) {
        for (Moments& node : moments_) {
            node.density *= denser;
            for (double& u : node.velocity) u *= faster;
        }
        flow.set_moments(0, moments_);
    }
    void keep(const Flow& flow) { flow.moments(0, moments_); }

    InertialCriterion criterion_;
    bool in_situ_;
    Drive drive_;
    Domain domain_;
    FlowSection section_;
    std::optional<Stretch> stretch_;
    std::map<Kernel, std::shared_ptr<const FlowPlan>> plans_;
    std::vector<Moments> moments_;
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

struct State {  // of a flow, in lattice units
    double viscosity, speed, force, permeability;
    bool two_times_stable = true;  ///< in means in time
};

// What the walls of the recursive collision do to k of creeping flow, relative to the steady scheme, at this viscosity (Re 0.001). The
// fields stay those of `state`.
double wall_error(Series& series, const InertialSeries& known, double length_lu, double viscosity, const State& state) {
    const double k_lu = known.creeping_permeability_m2 / (known.voxel_size_m * known.voxel_size_m), speed = 1e-3 * viscosity / length_lu,
                 force = viscosity * speed / k_lu;
    std::vector<Moments> fields = series.fields();
    const StokesRun run =
        series.solve(viscosity, force, Model::recursive, speed / state.speed, force / state.force, state.permeability / viscosity);
    series.set_fields(std::move(fields));
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
    double force;
    double walls = 0.0;
};
TimeAverage average(Series& series, const InertialSeries& known, double length_lu, double viscosity, double force, double speed,
                    State& state) {
    const double faster = speed / state.speed, denser = force / state.force;
    if (state.two_times_stable) {
        std::vector<Moments> fields = series.fields();
        try {
            return {series.average(viscosity, force, speed, length_lu, Model::navier_stokes, faster, denser), force};
        } catch (const FlowDiverged&) {
            log_info("two relaxation times are not stable any more: a more stable collision, with less accurate walls, from here on");
            state.two_times_stable = false;
            series.set_fields(std::move(fields));
        }
    }
    const double walls = wall_error(series, known, length_lu, viscosity, state), weaker = force / (1.0 + walls);
    return {series.average(viscosity, weaker, speed, length_lu, Model::recursive, faster, weaker / state.force), weaker, walls};
}

// The flow that should have the wanted Reynolds number; `state` becomes its own.
InertialFlow next_flow(Series& series, const InertialSeries& known, const InertialCriterion& criterion, double length_lu, double wanted,
                       double viscosity, State& state) {
    const double h2 = known.voxel_size_m * known.voxel_size_m, speed = wanted * viscosity / length_lu;
    double force = viscosity * speed * expected_resistance(known, wanted) * series.gradient() / series.resistance();
    double walls = 0.0;
    InertialFlow flow{.relaxation_time = 0.5 + 3.0 * viscosity};
    if (criterion.in_time) {
        const TimeAverage found = average(series, known, length_lu, viscosity, force, speed, state);
        const MeanFlow& mean = found.mean;
        force = found.force;
        walls = found.walls;
        state.speed = mean.superficial_velocity_lu;
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
        const StokesRun run =
            series.solve(viscosity, force, Model::navier_stokes, speed / state.speed, force / state.force, state.permeability / viscosity);
        state.speed = run.superficial_velocity_lu;
        flow.iteration_error = run.iteration_error;
        flow.converged = run.converged;
        flow.fastest_lu = series.fastest();
        flow.steps = run.steps;
        flow.seconds = run.seconds;
        if (!flow.converged)
            throw NumericalError(fmt::format("no steady flow within {} steps (iteration error {:.1e}, tolerance {:.1e})", run.steps,
                                             run.iteration_error, criterion.tolerance),
                                 {.fix = "compute the flow's mean in time (forchheimer.mean_in_time) on a periodic packing"});
    }
    state.viscosity = viscosity;
    state.force = force;
    state.permeability = viscosity * state.speed / series.resistance();
    flow.reynolds = state.speed * length_lu / viscosity;
    flow.permeability_m2 = state.permeability * h2 / (1.0 + walls);
    flow.momentum_share = 1.0 - series.gradient() / force;
    flow.kinetic_energy_share = series.kinetic_share();
    return flow;
}

}  // namespace

InertialSeries lbm_inertial_flows(const PoreSpace& space, double voxel_size_m, std::span<const double> reynolds, double length_m,
                                  const InertialCriterion& criterion, const Communicator& parts) {
    if (criterion.in_time && !space.container.periodic()[2])
        throw UserError("means in time need a box that is periodic along z: end planes would disturb a flow that is not steady",
                        {.fix = "leave mean_in_time out, or use a periodic packing"});
    Series series(space, voxel_size_m, criterion, parts);
    const double h = series.voxel_size(), length_lu = length_m / h;
    State state{.viscosity = creeping_viscosity_lu, .speed = 0.0, .force = 1e-6, .permeability = 0.0};
    if (criterion.in_time) state.two_times_stable = criterion.in_time->accurate_while_stable;
    const StokesRun creeping = series.solve(state.viscosity, state.force, Model::stokes, 0.0, 0.0, 0.0);
    if (!creeping.converged)
        throw NumericalError(fmt::format("creeping flow is not steady after {} steps; no permeability is given", creeping.steps),
                             {.fix = "raise max_steps"});
    state.speed = creeping.superficial_velocity_lu;
    state.permeability = state.viscosity * state.speed / series.resistance();
    InertialSeries result{.voxel_size_m = h,
                          .stretch = series.stretch(),
                          .nodes = series.nodes(),
                          .creeping_permeability_m2 = state.permeability * h * h,
                          .peak_over_mean = series.fastest() / state.speed,
                          .flows = {},
                          .stopped_by = {}};
    for (const auto& [wanted, viscosity] : plan_flows(result, criterion.in_time.has_value(), reynolds, length_lu)) {
        try {
            const InertialFlow flow = next_flow(series, result, criterion, length_lu, wanted, viscosity, state);
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
