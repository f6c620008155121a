// The state of a run to the steady flow: what it gives, and what it resumes from. Lattice units.
#pragma once

#include <array>
#include <vector>

#include "core/members.hpp"

namespace porepack::lbm {

/// For each layer of cells normal to the flow axis: its number of nodes, sums over them, and their mean density deviation. Lattice units.
struct Layers {
    std::vector<double> nodes;
    std::vector<double> flow;          ///< velocity along the axis
    std::vector<double> power;         ///< velocity along the axis times density deviation
    std::vector<double> kinetic;       ///< energy: u^2 / 2
    std::vector<double> kinetic_flux;  ///< velocity along the axis times u^2 / 2
    std::vector<double> elastic;       ///< energy of the density deviation: density^2 / 6, since the square of the speed of sound is 1/3
    std::vector<double> density;       ///< mean
};

/// What a correction of the pressure along the flow (layer_balance.hpp) must know of the one before.
struct BalanceState {
    std::vector<double> density = {};  ///< of the layers, after the correction
    double unsteady = 0.0;             ///< scatter of the unsteady part of the layers' flow rates
    double share = 0.7;  ///< upper limit of the fraction of the correction that is applied; smaller when the unsteady part grows
};
template <core::MembersOf<BalanceState> Self, typename Visit>
void visit_members(Self& state, const Visit& visit) {
    visit("layer_density", state.density);
    visit("layer_unsteady", state.unsteady);
    visit("layer_share", state.share);
}

/// One check of the run's state, the history of the convergence plot.
struct ConvergencePoint {
    long step = 0;
    double permeability_lu = 0.0;         ///< by the flow rate through the planes of the section
    double permeability_volume_lu = 0.0;  ///< by the mean flow rate of its layers
    double expected_lu = 0.0,
           expected_volume_lu = 0.0;  ///< the same in the steady state, to first order; with inertia not known: as they are
    double iteration_error = 0.0;     ///< relative
    double flow_imbalance = 0.0;      ///< maximum relative difference of the flow rate between layers
};
template <core::MembersOf<ConvergencePoint> Self, typename Visit>
void visit_members(Self& point, const Visit& visit) {
    visit("step", point.step);
    visit("permeability_lu", point.permeability_lu);
    visit("permeability_volume_lu", point.permeability_volume_lu);
    visit("expected_lu", point.expected_lu);
    visit("expected_volume_lu", point.expected_volume_lu);
    visit("iteration_error", point.iteration_error);
    visit("flow_imbalance", point.flow_imbalance);
}

struct StokesRun {
    double permeability_lu = 0.0;         ///< by the flow rate through the planes of the section, for the area of `area_cells`
    double permeability_volume_lu = 0.0;  ///< by the volume average between the planes
    double superficial_velocity_lu = 0.0;
    double gradient_lu = 0.0;            ///< driving pressure gradient over the section
    double hydraulic_tortuosity = 0.0;   ///< sum |u| / sum u_axis over the section's fluid
    double kinetic_energy_factor = 0.0;  ///< <u^2> / <u_axis>^2, means over the section's fluid
    std::array<double, 3> velocity_sum_lu = {0, 0, 0};
    double iteration_error = 0.0;  ///< estimated at the last check, plus drift_per_imbalance
    double flow_imbalance = 0.0;
    double mass_leak = 0.0;  ///< of a cell without end planes: density that the walls add per step, over that of the driving gradient
    bool converged = false;
    long steps = 0;
    double seconds = 0.0;
    double updates_per_second = 0.0;
    Layers layers = {};
    BalanceState balance = {};
    std::vector<ConvergencePoint> history = {};
};

}  // namespace porepack::lbm
