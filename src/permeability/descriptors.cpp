#include "permeability/descriptors.hpp"

#include <cmath>

namespace porepack::permeability {

BedNumbers bed_numbers(const PackedBed& bed) {
    const double k = bed.permeability_m2, eps = bed.porosity;
    BedNumbers numbers;
    numbers.sauter_diameter_m = 6.0 / bed.surface_per_solid_per_m;
    const double grains = (1.0 - eps) * bed.surface_per_solid_per_m, all = grains + bed.wall_per_bed_per_m;
    const auto kozeny = [&](double surface) { return eps * eps * eps / (k * surface * surface); };
    numbers.surface_per_bed_per_m = grains;
    numbers.surface_per_bed_with_wall_per_m = all;
    numbers.hydraulic_diameter_m = 4.0 * eps / grains;
    numbers.hydraulic_diameter_with_wall_m = 4.0 * eps / all;
    numbers.permeability_over_equivalent_diameter2 = k / std::pow(bed.equivalent_diameter_m, 2.0);
    numbers.permeability_over_sauter_diameter2 = k / std::pow(numbers.sauter_diameter_m, 2.0);
    numbers.kozeny_constant = kozeny(grains);
    numbers.kozeny_constant_with_wall = kozeny(all);
    numbers.carman_wall_factor = std::pow(all / grains, 2.0);
    return numbers;
}

Friction friction_of(double velocity, double viscosity, double permeability_m2, double diameter, double porosity) {
    const double solid = 1.0 - porosity, reynolds = velocity * diameter / (viscosity * solid);
    // dP/L = rho nu U / k.
    return {reynolds, viscosity * diameter * std::pow(porosity, 3.0) / (permeability_m2 * velocity * solid)};
}

double ergun_friction(double reynolds) {
    return 150.0 / reynolds + 1.75;
}

double carman_friction(double reynolds) {
    return 180.0 / reynolds + 2.4 * std::pow(6.0 / reynolds, 0.1);
}

double eisfeld_schnitzlein_friction(double reynolds, double diameter_over_container, double porosity) {
    const double a = 1.0 + 2.0 * diameter_over_container / (3.0 * (1.0 - porosity)),
                 b = std::pow(1.42 * diameter_over_container * diameter_over_container + 0.83, 2.0);
    return 155.0 * a * a / reynolds + a / b;
}

}  // namespace porepack::permeability
