#include "permeability/permeability.hpp"

#include <cmath>

namespace porepack::permeability {

double kozeny_function(double porosity) {
    const double solid = 1.0 - porosity;
    return porosity * porosity * porosity / (solid * solid);
}

double kozeny_uncertainty(double porosity, double standard_uncertainty) {
    return (3.0 / porosity + 2.0 / (1.0 - porosity)) * standard_uncertainty;
}

// Eq. (T23).
double carman_kozeny_m2(double sphericity, double equal_diameter_m, double porosity, double constant) {
    return sphericity * sphericity * equal_diameter_m * equal_diameter_m * kozeny_function(porosity) / constant;
}

// Eq. (T23).
double paper_fit_m2(double porosity) {
    return 5.3e-9 * std::exp(7.3 * porosity);
}

double velocity_at_onset_m_per_s(double part, double permeability_m2, double inertial_permeability_m, double kinematic_viscosity_m2_per_s) {
    return part / (1.0 - part) * kinematic_viscosity_m2_per_s * inertial_permeability_m / permeability_m2;
}

// Eq. (T23).
double ergun_inertial_m(double sphericity, double equal_diameter_m, double porosity) {
    return porosity * porosity * porosity * sphericity * equal_diameter_m / (1.75 * (1.0 - porosity));
}

double conductivity_m_per_s(double permeability_m2) {
    return permeability_m2 * 9.81 / 1e-6;
}

}  // namespace porepack::permeability
