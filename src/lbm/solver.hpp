// Iteration of a flow to its steady state, and its permeability. Lattice units.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "core/error.hpp"
#include "lbm/flow.hpp"
#include "lbm/iteration_error.hpp"
#include "lbm/stokes_run.hpp"

namespace porepack::lbm {

/// Not steady, and not becoming so: another viscosity may help.
struct FlowDiverged : core::NumericalError {
    using core::NumericalError::NumericalError;
};

struct ConvergenceCriterion {
    double tolerance = 1e-4;         ///< of the estimated relative iteration error of k
    long max_steps = 200000;         ///< then the run ends without having converged; raise it for long beds
    long steps_per_check = 40;       ///< even; the error is estimated this often, at the cost of about a step
    long min_steps = 0;              ///< with inertia: the estimated error is 1 before this step
    bool balance = true;             ///< correct the pressure along the flow at each check; Stokes flow only
    double max_seconds = 1e300;      ///< wall time; then the run ends without having converged
    bool stop_when_growing = false;  ///< FlowDiverged when the flow grows (iteration_error.hpp)
    /// Called when populations and run may be saved, by all slabs at the same step; `is_last`: an interrupted run ends then.
    std::function<void(const StokesRun&, bool is_last)> checkpoint = {};
    /// Called at each check with the share of the run's steps that is done, or nothing while that is not known. Default: a line of
    /// progress.
    std::function<void(long steps, std::optional<double> share, std::string_view detail)> progress = {};
};

/// Steps, from the state of `run`, until the estimated iteration error of both permeabilities (iteration_error.hpp) is below the
/// tolerance in two successive checks. Throws FlowDiverged on divergence (with the step).
/// When the criterion is not met, `converged` is false and the numbers must not be used.
[[nodiscard]] StokesRun run_to_steady(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                                      const ConvergenceCriterion& criterion, StokesRun run = {});

}  // namespace porepack::lbm
