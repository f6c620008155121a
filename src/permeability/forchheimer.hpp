// Forchheimer's law, 1/k_apparent = 1/k + (U/nu)/k_in, from the apparent permeabilities at rising Reynolds numbers.
#pragma once

#include <optional>
#include <span>

#include "core/interval.hpp"

namespace porepack {

struct ApparentPermeability {
    double reynolds = 0.0;  ///< U length / nu
    double permeability_m2 = 0.0;
    double relative_error = 0.0;  ///< of its own: of iteration
};

struct ForchheimerFit {
    double permeability_m2 = 0.0;               ///< of creeping flow
    double intercept_permeability_m2 = 0.0;     ///< of the straight part; a little more than k, for inertia sets in with Re^2
    double inertial_permeability_m = 0.0;       ///< k_in, slope of the straight part
    Interval inertial_interval_m = {};          ///< what the slopes of its parts and through 1/k, with their errors, span
    Interval extrapolated_interval_m = {};      ///< the same for Reynolds numbers beyond the last one
    double inertial_factor = 0.0;               ///< c_F = sqrt(k)/k_in (Ward 1964)
    std::optional<double> onset_reynolds = {};  ///< where the permeability is 5 % below k; none when no flow goes so far
    double largest_reynolds = 0.0;
    std::size_t points = 0;  ///< of the straight part
};

/// Beyond the last steady flow turbulence changes the coefficients: between Forchheimer's (Re 5 to 80) and the turbulent regime (Re > 120)
/// that of the inertial term falls by 16 % and that of the viscous one grows by 24 % in beds of spheres (Fand, Kim, Lam & Phan 1987, J.
/// Fluids Eng. 109). The interval is widened by as much.
inline constexpr double turbulent_change = 0.2;

/// The straight part are the flows with k_apparent below 0.95 k, at least the last three. The flows' errors count as independent of each
/// other; what they share, as the grid, is `relative_error` of the slope. Throws NumericalError with fewer than three flows, or when the
/// permeability does not fall.
[[nodiscard]] ForchheimerFit fit_forchheimer(double permeability_m2, double length_m, std::span<const ApparentPermeability> flows,
                                             double relative_error = 0.0);

}  // namespace porepack
