// Correlations for the permeability.
#pragma once

namespace porepack::permeability {

inline constexpr double darcy_m2 = 9.869233e-13;

/// eps^3 / (1 - eps)^2, to which k is proportional at constant area per volume of the solid (Kozeny, Carman).
[[nodiscard]] double kozeny_function(double porosity);
/// Standard uncertainty of its logarithm.
[[nodiscard]] double kozeny_uncertainty(double porosity, double standard_uncertainty);

/// Carman-Kozeny, Eq. 2: k = Psi^2 d^2 eps^3 / (constant (1 - eps)^2). The paper uses 150; 180 fits spheres better.
[[nodiscard]] double carman_kozeny_m2(double sphericity, double equal_diameter_m, double porosity, double constant);
/// The paper's fit, Eq. 22 corrected: k = 5.3e-9 exp(7.3 eps) m2 (for grains of 733 mm3).
[[nodiscard]] double paper_fit_m2(double porosity);
/// Ergun: k_in = eps^3 Psi d / (1.75 (1 - eps)), metres.
[[nodiscard]] double ergun_inertial_m(double sphericity, double equal_diameter_m, double porosity);
/// Superficial velocity at which inertia makes the apparent permeability smaller than k by the fraction `part`, from
/// k_apparent / k = 1 / (1 + (U/nu) k / k_in).
[[nodiscard]] double velocity_at_onset_m_per_s(double part, double permeability_m2, double inertial_permeability_m,
                                               double kinematic_viscosity_m2_per_s);
/// Hydraulic conductivity for nu = 1e-6 m2/s (water at about 20 degrees Celsius; fluid.hpp has other fluids), m/s: k g / nu.
[[nodiscard]] double conductivity_m_per_s(double permeability_m2);

}  // namespace porepack::permeability
