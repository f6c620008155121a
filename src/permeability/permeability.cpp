#include "permeability/permeability.hpp"

#include <cmath>

namespace porepack::permeability {

double carman_kozeny_m2(double sphericity, double equal_diameter_m, double porosity, double constant) {
    const double solid = 1.0 - porosity;
    return sphericity * sphericity * equal_diameter_m * equal_diameter_m * porosity * porosity * porosity / (constant * solid * solid);
}

double paper_fit_m2(double porosity) {
    return 5.3e-9 * std::exp(7.3 * porosity);
}

double ergun_inertial_m(double sphericity, double equal_diameter_m, double porosity) {
    return porosity * porosity * porosity * sphericity * equal_diameter_m / (1.75 * (1.0 - porosity));
}

double conductivity_m_per_s(double permeability_m2) {
    return permeability_m2 * 9.81 / 1e-6;
}

}  // namespace porepack::permeability
