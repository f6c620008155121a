// Dimensionless numbers of a packing, for comparison with correlations and with beds of other sizes.
#pragma once

#include "core/members.hpp"

namespace porepack::permeability {

/// What the numbers follow from. Lengths in metres.
struct PackedBed {
    double porosity = 0.0;
    double permeability_m2 = 0.0;
    double equivalent_diameter_m = 0.0;    ///< d_v, of the sphere with the mean volume of a grain; 0 where unknown
    double surface_per_solid_per_m = 0.0;  ///< area of the grains over their volume; 0 without grains
    double wall_per_bed_per_m = 0.0;       ///< area of the container's side wall over the volume of the section: 4/D of a cylinder
};

struct BedNumbers {
    double sauter_diameter_m = 0.0;                ///< d_32 = 6 / surface_per_solid
    double surface_per_bed_per_m = 0.0;            ///< S, area of the grains over the volume of the section
    double surface_per_bed_with_wall_per_m = 0.0;  ///< S and the container's wall
    double hydraulic_diameter_m = 0.0;             ///< 4 eps / S
    double hydraulic_diameter_with_wall_m = 0.0;
    double permeability_over_equivalent_diameter2 = 0.0;  ///< k / d_v^2, the Darcy number of d_v
    double permeability_over_sauter_diameter2 = 0.0;      ///< k / d_32^2
    double kozeny_constant = 0.0;            ///< k_K = eps^3 / (k S^2); 2 in a circular pipe, 3 in a slit, about 5 in beds (Carman 1937)
    double kozeny_constant_with_wall = 0.0;  ///< with the container's wall in S
    double carman_wall_factor = 0.0;         ///< k of an infinitely wide bed over k, (S with wall / S)^2: Carman's correction (1937)
};
template <core::MembersOf<BedNumbers> Self, typename Visit>
void visit_members(Self& numbers, const Visit& visit) {
    visit("sauter_diameter_m", numbers.sauter_diameter_m);
    visit("surface_per_bed_per_m", numbers.surface_per_bed_per_m);
    visit("surface_per_bed_with_wall_per_m", numbers.surface_per_bed_with_wall_per_m);
    visit("hydraulic_diameter_m", numbers.hydraulic_diameter_m);
    visit("hydraulic_diameter_with_wall_m", numbers.hydraulic_diameter_with_wall_m);
    visit("permeability_over_equivalent_diameter2", numbers.permeability_over_equivalent_diameter2);
    visit("permeability_over_sauter_diameter2", numbers.permeability_over_sauter_diameter2);
    visit("kozeny_constant", numbers.kozeny_constant);
    visit("kozeny_constant_with_wall", numbers.kozeny_constant_with_wall);
    visit("carman_wall_factor", numbers.carman_wall_factor);
}

/// A number that does not exist, such as the Kozeny constant of a bed without any surface, is infinite or NaN.
[[nodiscard]] BedNumbers bed_numbers(const PackedBed& bed);

/// Modified Reynolds number Re_m = U d_32 / (nu (1 - eps)) and friction factor f = dP/L d_32 eps^3 / (rho U^2 (1 - eps)) of packed beds,
/// in which Ergun's equation is f = 150/Re_m + 1.75. `permeability_m2` is the apparent one, nu U L rho / dP.
struct Friction {
    double reynolds, factor;
};
[[nodiscard]] Friction friction_of(double superficial_velocity_m_per_s, double viscosity_m2_per_s, double permeability_m2,
                                   double sauter_diameter_m, double porosity);
/// Ergun (1952): 150/Re + 1.75.
[[nodiscard]] double ergun_friction(double reynolds);
/// Carman (1937): 180/Re + 2.87/Re^0.1.
[[nodiscard]] double carman_friction(double reynolds);
/// Eisfeld & Schnitzlein (2001) with the constants of all their particles, for beds in cylinders: 155 A^2/Re + A/B,
/// A = 1 + 2 d / (3 D (1 - eps)), B = (1.42 (d/D)^2 + 0.83)^2, with d = d_32.
[[nodiscard]] double eisfeld_schnitzlein_friction(double reynolds, double diameter_over_container, double porosity);

}  // namespace porepack::permeability
