// Pressure drop of a bed at a flow rate, from its permeability and its computed flows with inertia.
#pragma once

#include <optional>

#include "core/interval.hpp"
#include "permeability/fluid.hpp"
#include "permeability/forchheimer.hpp"

namespace porepack::permeability {

/// k / k_apparent at a Reynolds number, and the relative half width of its interval: the change to the coarser grid (beyond its last flow,
/// growing like the inertia), twice the flows' own errors, and what is uncertain between two flows.
struct InertialFactor {
    double value = 1.0;
    double half_width = 0.0;
};
/// Between two flows, k / k_apparent - 1 is a power of the Reynolds number; below the first one, between its first and second power. Throws
/// UserError beyond the largest Reynolds number of `fine`.
[[nodiscard]] InertialFactor inertial_factor(const InertialCurve& fine, const std::optional<InertialCurve>& coarse, double reynolds);

/// The same where no flow with inertia was computed: 1, with an error of c_F U sqrt(k) / nu, c_F = 0.55 (Ward 1964).
[[nodiscard]] InertialFactor creeping_factor(double superficial_velocity_m_per_s, double permeability_m2, double viscosity_m2_per_s);
/// Beyond this error, flows with inertia must be computed.
inline constexpr double largest_neglected_inertia = 0.01;

/// mu U / k times the factor, Pa/m; the intervals of both are combined as independent errors.
struct PressureGradient {
    double value = 0.0;
    core::Interval interval = {};
};
[[nodiscard]] PressureGradient pressure_gradient(double superficial_velocity_m_per_s, const Fluid& fluid, double permeability_m2,
                                                 const core::Interval& permeability_interval_m2, const InertialFactor& factor);

/// f_v = dP d^2 eps^3 / (mu U L (1 - eps)^2) of beds of spheres as measured, 160 + 2.81 Re^0.904 with Re = rho U d / (mu (1 - eps)); 95 of
/// 100 measurements lie within 15 % (Erdim, Akgiray & Demir 2015; 4 < D/d < 34.1, 0.377 < eps < 0.470).
[[nodiscard]] double erdim_gradient(double superficial_velocity_m_per_s, const Fluid& fluid, double diameter_m, double porosity);
/// Ergun (1952), with 150 and 1.75.
[[nodiscard]] double ergun_gradient(double superficial_velocity_m_per_s, const Fluid& fluid, double diameter_m, double porosity);

}  // namespace porepack::permeability
