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
    double widening = 1.0;              ///< of the interval of 1/k, over that of noise that is independent from frame to frame
    double slow_widening = 1.0;         ///< further, if the noise certainly has a part slower than a quarter of the longest curve
    double slow_probability = 0.0;      ///< that it has
    double white_probability = 1.0;     ///< that the noise is independent from frame to frame
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
    [[nodiscard]] bool noise_correlated() const { return white_probability < 0.05; }
    /// The noise has a part that is hardly faster than the curves: they hold too few of its periods to tell its size.
    [[nodiscard]] bool noise_unknown() const { return slow_probability > 0.5; }
};

/// All curves share the resistances; each has its first level and, with the water's inertia, its first speed fitted too. The curves are
/// windows of at least five points (take_window). Level offset, scale, viscosity, inertia coefficient and inertial exponent are fitted as
/// well where the config gives them an uncertainty (a normal prior). The noise may be correlated over all lags
/// (noise.hpp): the intervals are wider. Throws NumericalError when no fit is found.
[[nodiscard]] FallingHeadFit fit_falling_head(std::span<const LevelCurve> curves, const FallingHeadConfig& config);

}  // namespace porepack::falling_head
