// Iteration of a flow to its steady state, and its permeability. Lattice units.
#pragma once

#include <functional>

#include "core/members.hpp"
#include "lbm/flow.hpp"

namespace porepack::lbm {

/// For each layer of cells normal to the flow axis: sum of the velocity along it, sum of velocity times density deviation, and mean
/// density deviation.
struct Layers {
    std::vector<double> flow, power, density;
};
[[nodiscard]] Layers measure_layers(const Flow& flow, const Domain& domain);

/// The pressure on a plane through the flow.
enum class PlanePressure {
    flux_weighted,  ///< int p u dA / int u dA: flow rate times its difference is the power that is dissipated in between
    mean            ///< over the fluid
};
/// Pressure gradient that drives the flow between the layers first and last: the body force `force`, and the drop of the remaining
/// pressure between the planes before and behind them.
[[nodiscard]] double gradient_between(double force, const converters::Drive& drive, const Layers& layers, std::size_t first,
                                      std::size_t last, PlanePressure pressure = PlanePressure::flux_weighted);

/// One check of the run's state, the history of the convergence plot.
struct ConvergencePoint {
    long step = 0;
    double permeability_lu = 0.0, permeability_volume_lu = 0.0;
    double iteration_error = 0.0;  ///< relative
    double flow_imbalance = 0.0;   ///< maximum relative difference of the flow rate between layers
};
template <core::MembersOf<ConvergencePoint> Self, typename Visit>
void visit_members(Self& point, const Visit& visit) {
    visit("step", point.step);
    visit("permeability_lu", point.permeability_lu);
    visit("permeability_volume_lu", point.permeability_volume_lu);
    visit("iteration_error", point.iteration_error);
    visit("flow_imbalance", point.flow_imbalance);
}

struct StokesRun {
    double permeability_lu = 0.0;         ///< by the flow rate through the planes of the section, for the area of `area_cells`
    double permeability_volume_lu = 0.0;  ///< by the volume average between the planes
    double superficial_velocity_lu = 0.0;
    double gradient_lu = 0.0;           ///< driving pressure gradient over the section
    double hydraulic_tortuosity = 0.0;  ///< sum |u| / sum u_axis over the section's fluid
    std::array<double, 3> velocity_sum_lu = {0, 0, 0};
    double iteration_error = 0.0;
    double flow_imbalance = 0.0;
    bool converged = false;
    long steps = 0;
    double seconds = 0.0;
    double updates_per_second = 0.0;
    Layers layers = {};
    std::vector<double> layer_density = {};  ///< at the last check, corrections included; for the next correction
    std::vector<ConvergencePoint> history = {};
};

struct ConvergenceCriterion {
    double tolerance = 1e-4;                                ///< of the estimated relative iteration error of k
    long max_steps = 200000;                                ///< then the run ends without having converged; raise it for long beds
    long steps_per_check = 40;                              ///< even; the error is estimated this often, at the cost of about a step
    bool balance = true;                                    ///< correct the pressure along the flow at each check; Stokes flow only
    double max_seconds = 1e300;                             ///< wall time; then the run ends without having converged
    std::function<void(const StokesRun&)> checkpoint = {};  ///< called when populations and run may be saved
};

/// The cross-section that the flow rate is divided by, and the layers between the planes of the section.
struct FlowSection {
    double area_cells = 0.0;
    int first_layer = 0;
    int last_layer = 0;  ///< inclusive
};

/// Steps, from the state of `run`, until the remaining change of both permeabilities is below the tolerance in two successive checks, as
/// estimated from the last fifths of the history, assumed geometric. Throws NumericalError on divergence (with the step).
/// When the criterion is not met, `converged` is false and the numbers must not be used.
[[nodiscard]] StokesRun run_to_steady(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                                      const ConvergenceCriterion& criterion, StokesRun run = {});

}  // namespace porepack::lbm
