#include "permeability/fluid.hpp"

#include <cmath>
#include <numbers>

namespace porepack::permeability {
namespace {

Fluid water_at(double t) {
    const double density =
        (999.83952 + t * (16.945176 + t * (-7.9870401e-3 + t * (-46.170461e-6 + t * (105.56302e-9 - t * 280.54253e-12))))) /
        (1.0 + 16.879850e-3 * t);
    const double relative = (t + 273.15) / 300.0;
    const double viscosity = 1e-6 * (280.68 * std::pow(relative, -1.9) + 511.45 * std::pow(relative, -7.7) +
                                     61.131 * std::pow(relative, -19.6) + 0.45903 * std::pow(relative, -40.0));
    return {density, viscosity};
}

constexpr double gas_constant_J_per_kg_K = 287.05, zero_C_K = 273.15;  // of air

Fluid air_at(double t) {
    constexpr double sutherland_K = 110.4, viscosity_at_0_C = 1.716e-5;
    const double kelvin = t + zero_C_K;
    return {101325.0 / (gas_constant_J_per_kg_K * kelvin),
            viscosity_at_0_C * std::pow(kelvin / zero_C_K, 1.5) * (zero_C_K + sutherland_K) / (kelvin + sutherland_K)};
}

}  // namespace

Fluid fluid_at(FluidName name, double temperature_C) {
    return name == FluidName::water ? water_at(temperature_C) : air_at(temperature_C);
}

std::optional<double> knudsen_number(FluidName name, double temperature_C, double permeability_m2, double porosity) {
    if (name != FluidName::air) return std::nullopt;
    const Fluid air = air_at(temperature_C);
    const double mean_free_path_m = air.viscosity_Pa_s / air.density_kg_per_m3 *
                                    std::sqrt(std::numbers::pi / (2.0 * gas_constant_J_per_kg_K * (temperature_C + zero_C_K)));
    return mean_free_path_m / std::sqrt(32.0 * permeability_m2 / porosity);
}

double hydraulic_conductivity_m_per_s(double permeability_m2, const Fluid& fluid) {
    return permeability_m2 * fluid.density_kg_per_m3 * 9.81 / fluid.viscosity_Pa_s;
}

}  // namespace porepack::permeability
