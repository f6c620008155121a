// Density and viscosity of named fluids, for the hydraulic conductivity.
#pragma once

#include <array>
#include <optional>

#include "core/choice.hpp"

namespace porepack::permeability {

enum class FluidName { water, air };
constexpr std::array<core::Choice<FluidName>, 2> choices_of(FluidName) {
    return {{{FluidName::water, "water"}, {FluidName::air, "air"}}};
}

struct Fluid {
    double density_kg_per_m3;
    double viscosity_Pa_s;  ///< dynamic
};

/// At 101325 Pa and 0 to 100 degrees Celsius. Water: Kell (1975), IAPWS (2008, the simple equation for 0.1 MPa); air: ideal gas,
/// Sutherland.
[[nodiscard]] Fluid fluid_at(FluidName name, double temperature_C);

/// Mean free path of the molecules over the pore size sqrt(32 k / eps), which is the diameter of straight tubes of the same k and porosity;
/// nothing for a liquid. In such tubes, slip on the walls raises k by 8 times this number where it is small (Klinkenberg 1941; Maxwell's
/// slip, diffuse reflection).
[[nodiscard]] std::optional<double> knudsen_number(FluidName name, double temperature_C, double permeability_m2, double porosity);
/// From this number on, k of a gas is not that of a liquid.
inline constexpr double max_knudsen_number = 0.01;

/// Hydraulic conductivity K = k rho g / mu, m/s, with g = 9.81 m/s2.
[[nodiscard]] double hydraulic_conductivity_m_per_s(double permeability_m2, const Fluid& fluid);

}  // namespace porepack::permeability
