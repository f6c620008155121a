// Resistances of a sample from measured falling-head curves: nonlinear least squares of the full equation (column.hpp) in 1/k and 1/k_in,
// with profile-likelihood intervals.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "falling_head/column.hpp"
#include "falling_head/level_curve.hpp"

namespace porepack::falling_head {

/// One fitted number with its 95 % interval: all values that, with all other parameters refitted, raise the sum of squares by no more than
/// expected by chance (Student's t).
struct FittedValue {
    double value = 0.0;
    core::Interval interval = {};
};

struct FallingHeadFit {
    FittedValue inverse_permeability_per_m2 = {};          ///< 1/k; may be negative
    FittedValue inverse_inertial_permeability_per_m = {};  ///< 1/k_in
    double correlation = 0.0;                              ///< of both
    /// Fitted within their uncertainties; equal to the given values where these are 0.
    double level_offset_m = 0.0, scale_error = 0.0, kinematic_viscosity_m2_per_s = 0.0, inertia_coefficient = 0.0, inertial_exponent = 0.0;
    double residual_correlation = 0.0;  ///< between neighbouring frames
    double widening = 1.0;              ///< of the intervals, because of it
    double residual_m = 0.0;            ///< standard deviation of the levels about the fit
    double noise_m = 0.0;               ///< of the levels themselves, from second differences
    double viscous_share = 0.0;         ///< fraction of the head over the window due to 1/k
    long points = 0;
    std::vector<std::vector<double>> levels_m;  ///< of the fit, curve by curve

    /// k and its interval; none if 1/k is not positive, and an infinite upper bound if 1/k may be zero.
    [[nodiscard]] std::optional<double> permeability_m2() const;
    [[nodiscard]] core::Interval permeability_interval_m2() const;
    /// "k is determined to -x/+y %", "this test bounds k only from below: k > ...", or that no k explains the data.
    [[nodiscard]] std::string verdict() const;
    [[nodiscard]] std::string inertial_verdict() const;
};

/// All curves share the resistances; each has its first level and, with the water's inertia, its first speed fitted too. The curves are
/// windows of at least five points (take_window). Level offset, scale, viscosity, inertia coefficient and inertial exponent are fitted as
/// well where the config gives them an uncertainty (a normal prior). Where the residuals of neighbouring frames have a correlation r, n
/// frames count as n (1 - r)/(1 + r): the intervals are wider. Throws NumericalError when no fit is found.
[[nodiscard]] FallingHeadFit fit_falling_head(std::span<const LevelCurve> curves, const FallingHeadConfig& config);

}  // namespace porepack::falling_head
