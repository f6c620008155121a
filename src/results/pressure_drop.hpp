// Pressure drop of a case's bed at a flow rate: `porepack pressure-drop`.
#pragma once

#include <optional>
#include <string>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

struct PressureDrop {
    static constexpr long version = 1;
    std::string fluid;
    double density_kg_per_m3 = 0.0, viscosity_Pa_s = 0.0;
    double flow_rate_m3_per_s = 0.0, superficial_velocity_m_per_s = 0.0;
    double length_m = 0.0;
    std::string length_is;
    double porosity = 0.0, permeability_m2 = 0.0;
    core::OptionalKey<double> reynolds = {};           ///< U d / nu, as in forchheimer; not of images
    core::OptionalKey<double> reynolds_modified = {};  ///< U d_32 / (nu (1 - eps)), of Ergun's equation
    double inertia_factor = 1.0;                       ///< k / k_apparent
    double inertia_half_width = 0.0;                   ///< relative, of 95 %
    double pressure_drop_Pa = 0.0;
    core::Interval pressure_drop_interval_Pa = {};  ///< of 95 %: of this packing
    std::string interval_meaning;
    core::OptionalKey<core::Interval> next_such_packing_Pa = {};  ///< none where its k may be 0
    double pressure_gradient_Pa_per_m = 0.0;
    // For comparison: correlations for beds of spheres, with this porosity and d_32.
    core::OptionalKey<double> ergun_Pa = {}, erdim_Pa = {};
};
template <core::MembersOf<PressureDrop> Self, typename Visit>
void visit_members(Self& drop, const Visit& visit) {
    visit("fluid", drop.fluid);
    visit("density_kg_per_m3", drop.density_kg_per_m3);
    visit("viscosity_Pa_s", drop.viscosity_Pa_s);
    visit("flow_rate_m3_per_s", drop.flow_rate_m3_per_s);
    visit("superficial_velocity_m_per_s", drop.superficial_velocity_m_per_s);
    visit("length_m", drop.length_m);
    visit("length_is", drop.length_is);
    visit("porosity", drop.porosity);
    visit("permeability_m2", drop.permeability_m2);
    visit("reynolds", drop.reynolds);
    visit("reynolds_modified", drop.reynolds_modified);
    visit("inertia_factor", drop.inertia_factor);
    visit("inertia_half_width", drop.inertia_half_width);
    visit("pressure_drop_Pa", drop.pressure_drop_Pa);
    visit("pressure_drop_interval_Pa", drop.pressure_drop_interval_Pa);
    visit("interval_meaning", drop.interval_meaning);
    visit("next_such_packing_Pa", drop.next_such_packing_Pa);
    visit("pressure_gradient_Pa_per_m", drop.pressure_gradient_Pa_per_m);
    visit("ergun_Pa", drop.ergun_Pa);
    visit("erdim_Pa", drop.erdim_Pa);
}

}  // namespace porepack::results
