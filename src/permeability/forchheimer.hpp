// Forchheimer's law, 1/k_apparent = 1/k + (U/nu)/k_in, from the apparent permeabilities at increasing Reynolds numbers.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::permeability {

struct ApparentPermeability {
    double reynolds = 0.0;  ///< U length / nu
    double permeability_m2 = 0.0;
    double relative_error = 0.0;  ///< independent part: iteration error
};

struct ForchheimerFit {
    double permeability_m2 = 0.0;                 ///< of creeping flow
    double intercept_permeability_m2 = 0.0;       ///< of the straight part; slightly larger than k, because inertia starts with Re^2
    double inertial_permeability_m = 0.0;         ///< k_in, slope of the straight part
    core::Interval inertial_interval_m = {};      ///< range of the slopes of its parts and through 1/k, with their errors
    core::Interval extrapolated_interval_m = {};  ///< the same for Reynolds numbers beyond the last one
    double inertial_factor = 0.0;                 ///< c_F = sqrt(k)/k_in (Ward 1964)
    std::optional<double> onset_reynolds = {};    ///< Re at which the permeability is 5 % below k; none if no flow reaches it
    double largest_reynolds = 0.0;
    std::size_t points = 0;  ///< number of flows in the straight part
};
template <core::MembersOf<ForchheimerFit> Self, typename Visit>
void visit_members(Self& fit, const Visit& visit) {
    visit("creeping_permeability_m2", fit.permeability_m2);
    visit("intercept_permeability_m2", fit.intercept_permeability_m2);
    visit("inertial_permeability_m", fit.inertial_permeability_m);
    visit("inertial_permeability_interval_m", fit.inertial_interval_m);
    visit("inertial_permeability_extrapolated_interval_m", fit.extrapolated_interval_m);
    visit("inertial_factor", fit.inertial_factor);
    visit("onset_reynolds", fit.onset_reynolds);
    visit("largest_reynolds", fit.largest_reynolds);
    visit("points", fit.points);
}

/// Beyond the last steady flow turbulence changes the coefficients: from the Forchheimer regime (Re 5 to 80) to turbulence (Re > 120)
/// the inertial coefficient decreases by 16 % and the viscous one increases by 24 % in beds of spheres (Fand, Kim, Lam & Phan 1987, J.
/// Fluids Eng. 109). The interval is widened by the same amount.
inline constexpr double turbulent_change = 0.2;

/// The straight part is the flows with k_apparent below 0.95 k, at least the last three. Their errors are assumed independent of each
/// other; common errors, as of the grid, are `relative_error` of the slope. Throws NumericalError with fewer than three flows, or when the
/// permeability does not fall.
[[nodiscard]] ForchheimerFit fit_forchheimer(double permeability_m2, double length_m, std::span<const ApparentPermeability> flows,
                                             double relative_error = 0.0);

/// Apparent permeabilities on one grid, and that of creeping flow.
struct InertialCurve {
    double permeability_m2 = 0.0;
    std::vector<ApparentPermeability> flows;  ///< at rising Reynolds numbers
};
/// Relative change of 1/k_in from a coarse grid to the next finer one, by the flows common to both; none for fewer than three.
[[nodiscard]] std::optional<double> inertial_grid_error(const InertialCurve& coarse, const InertialCurve& fine, double length_m);

/// Kinematic pressure drops (m2/s2) over a section of `section_m` that should give these Reynolds numbers, by the flows of a curve that is
/// known and, beyond its last one, by its fit. The first drop is that of creeping flow at Re 0.01.
[[nodiscard]] std::vector<double> pressure_drops(std::span<const double> reynolds, const InertialCurve& known, const ForchheimerFit& fit,
                                                 double section_m, double length_m, double viscosity_m2_per_s);

}  // namespace porepack::permeability
