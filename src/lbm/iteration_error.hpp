// How far k is from its value in the steady state: two estimates that do not depend on each other. Theory in docs/theory.md.
#pragma once

#include "core/members.hpp"
#include "lbm/layers.hpp"

namespace porepack::lbm {

/// The cross-section that the flow rate is divided by, and the layers between the planes of the section.
struct FlowSection {
    double area_cells = 0.0;
    int first_layer = 0;
    int last_layer = 0;  ///< inclusive
};

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

/// What a Stokes flow still lacks, from two states that are `steps` apart. To first order in the distance from the steady state,
/// whatever modes it consists of.
struct Unsteadiness {
    double energy = 0.0;  ///< rate of (kinetic - elastic energy) of the section over the power of the driving gradient
    double mass = 0.0;    ///< flow rate through the planes less that of the mean layer, as far as layers gain mass; over the flow rate
    /// Permeability in the steady state from the present one.
    [[nodiscard]] double expected_volume(double permeability_volume) const { return permeability_volume * (1.0 + energy); }
    [[nodiscard]] double expected(double permeability) const { return permeability * (1.0 + energy - mass); }
};
[[nodiscard]] Unsteadiness unsteadiness(const converters::Drive& drive, const FlowSection& section, const Layers& before, const Layers& now,
                                        long steps, double gradient);

/// Estimated relative distance of both permeabilities of the last check from the steady state, for the convergence criterion: 1.5 times
/// the first-order change, the larger of the last two checks, plus twice what the history of the expected permeabilities shows of
/// further change. 1 before the third check. Calibrated on random slow flows (`porepack benchmark iteration`).
[[nodiscard]] double iteration_error(const std::vector<ConvergencePoint>& history);

/// Part of the flow imbalance by which k may still creep while walls that leak fill pockets of fluid; no estimate shows it in time.
/// Added to the error that a run reports.
inline constexpr double creep_of_imbalance = 0.005;

}  // namespace porepack::lbm
