// How far k is from its value in the steady state: two estimates that do not depend on each other. Theory in docs/theory.md.
#pragma once

#include <optional>
#include <vector>

#include "lbm/layers.hpp"

namespace porepack::lbm {

/// The cross-section that the flow rate is divided by, and the layers between the planes of the section.
struct FlowSection {
    double area_cells = 0.0;
    int first_layer = 0;
    int last_layer = 0;  ///< inclusive
};

/// Relative difference between the present and the steady permeability of a Stokes flow, from two states that are `steps` apart. Exact
/// to first order in this difference, for any mixture of modes, as far as walls conserve mass.
struct Unsteadiness {
    double energy = 0.0;  ///< rate of (kinetic - elastic energy) of the section over the power of the driving gradient
    /// (flow rate of the first and the last layer - mean flow rate) / flow rate, only the part that is due to layers that gain mass.
    double mass = 0.0;
    /// Permeability in the steady state from the present one.
    [[nodiscard]] double expected_volume(double permeability_volume) const { return permeability_volume * (1.0 + energy); }
    [[nodiscard]] double expected(double permeability) const { return permeability * (1.0 + energy - mass); }
};
/// `force`: the body force; `gradient`: the gradient that drives the section, force and pressure together.
[[nodiscard]] Unsteadiness unsteadiness(const pore_space::Drive& drive, const FlowSection& section, const Layers& before, const Layers& now,
                                        long steps, double force, double gradient);

/// Estimated relative distance of both permeabilities from the steady state, for the convergence criterion: 1.5 times the first-order
/// difference (maximum of the last two checks) + 2 times the further change that is extrapolated from the history of the expected
/// permeabilities. 1 before the third check. Calibrated on random slow flows (`porepack benchmark iteration`).
[[nodiscard]] double iteration_error(const std::vector<ConvergencePoint>& history);

/// The same for a flow with inertia, whose steady permeability is not known to first order: twice the change that remains of k, from
/// what k has covered in the last fifth and in the last third of the checks and in as many before. It is never less than what k
/// has covered in those last checks, so that no k that stands still for a moment, nor one that swings, is taken for a steady one. 1 before
/// the twelfth check. How often it holds: `porepack benchmark iteration`.
[[nodiscard]] double iteration_error_with_inertia(const std::vector<ConvergencePoint>& history);

/// Whether the flow grows instead of becoming steady, which walls in pores of a few nodes can cause: the second half of the checks, in four
/// equal parts, has ranges of the expected permeability that grow by a factor of 1.5 or more from part to part, the last above the
/// tolerance (relative). Slow modes pass this by: their changes become smaller with time, and what they add to the estimated error as the
/// history gets longer, and the estimate passes through small values by chance, does not count.
[[nodiscard]] bool grows(const std::vector<ConvergencePoint>& history, double tolerance);

/// Share of the steps that are done if the error goes on falling as in the second half of the checks; nothing while that is not known.
[[nodiscard]] std::optional<double> share_of_steps(const std::vector<ConvergencePoint>& history, double tolerance);

/// Walls that do not conserve mass slowly change the pressure in dead-end pores, and k then drifts too slowly for the estimate. This
/// factor times the flow imbalance covers the drift and is added to the error that a run reports.
inline constexpr double drift_per_imbalance = 0.005;

}  // namespace porepack::lbm
