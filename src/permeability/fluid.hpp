// Density and viscosity of named fluids, for the hydraulic conductivity.
#pragma once

#include <array>

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

/// Hydraulic conductivity K = k rho g / mu, m/s, with g = 9.81 m/s2.
[[nodiscard]] double hydraulic_conductivity_m_per_s(double permeability_m2, const Fluid& fluid);

}  // namespace porepack::permeability
