// Numbers of beds and fluids by hand.
#include <cmath>
#include <initializer_list>

#include "core/error.hpp"
#include "permeability/descriptors.hpp"
#include "permeability/fluid.hpp"
#include "permeability/permeability.hpp"
#include "permeability/pressure_drop.hpp"
#include "support/basics.hpp"

namespace porepack {
using namespace permeability;
namespace {

TEST(Descriptors, KozenyConstantOfPipeAndSlit) {
    // A pipe of diameter 2 mm: k = D^2/32 and only the wall has an area; a slit of width 2 mm: k = w^2/12, area 2/w.
    const double d = 2e-3;
    EXPECT_NEAR(bed_numbers({.porosity = 1.0, .permeability_m2 = d * d / 32.0, .wall_per_bed_per_m = 4.0 / d}).kozeny_constant_with_wall,
                2.0, 1e-12);
    EXPECT_NEAR(bed_numbers({.porosity = 1.0, .permeability_m2 = d * d / 12.0, .wall_per_bed_per_m = 2.0 / d}).kozeny_constant_with_wall,
                3.0, 1e-12);
}

TEST(Descriptors, SpheresByHand) {
    // Spheres of 1 mm at porosity 0.4 with k by Carman-Kozeny with 180: k_K is 5, and 4 eps / S is 2 eps d / (3 (1 - eps)).
    const double d = 1e-3, k = d * d * 0.064 / (180.0 * 0.36);
    const BedNumbers numbers = bed_numbers({.porosity = 0.4,
                                            .permeability_m2 = k,
                                            .equivalent_diameter_m = d,
                                            .surface_per_solid_per_m = 6.0 / d,
                                            .wall_per_bed_per_m = 400.0});
    EXPECT_NEAR(numbers.sauter_diameter_m, d, 1e-15);
    EXPECT_NEAR(numbers.kozeny_constant, 5.0, 1e-12);
    EXPECT_NEAR(numbers.hydraulic_diameter_m, 2.0 * 0.4 * d / (3.0 * 0.6), 1e-15);
    EXPECT_NEAR(numbers.permeability_over_equivalent_diameter2, 0.064 / 64.8, 1e-15);
    EXPECT_NEAR(numbers.carman_wall_factor, std::pow(4000.0 / 3600.0, 2.0), 1e-12);
    // At creeping flow, f Re is 180; Carman's equation at 6 in his Reynolds number is 180/Re + 2.4.
    const Friction friction = friction_of(1e-4, 1e-6, k, d, 0.4);
    EXPECT_NEAR(friction.reynolds, 1e-7 / (1e-6 * 0.6), 1e-12);
    EXPECT_NEAR(friction.factor * friction.reynolds, 180.0, 1e-9);
    EXPECT_NEAR(carman_friction(6.0), 32.4, 1e-12);
    EXPECT_NEAR(ergun_friction(100.0), 3.25, 1e-12);
    // Eisfeld & Schnitzlein without a wall: A = 1 and B = 0.83^2.
    EXPECT_NEAR(eisfeld_schnitzlein_friction(155.0, 0.0, 0.4), 1.0 + 1.0 / (0.83 * 0.83), 1e-12);
}

// 65 nm at 20 degrees Celsius and normal pressure; pores of 6.5 um have 0.01.
TEST(KnudsenNumber, OfAirInNarrowPores) {
    EXPECT_FALSE(knudsen_number(FluidName::water, 20.0, 1e-15, 0.4));
    EXPECT_NEAR(knudsen_number(FluidName::air, 20.0, 0.4 * 1e-6 * 1e-6 / 32.0, 0.4).value(), 0.0652, 0.001);
}

TEST(Correlations, CarmanKozeny) {
    // Eq. 2 by hand: 0.53^2 * 0.0111867^2 * 0.343 / (150 * 0.09).
    // Water: 998.21 kg/m3 and 1.0016 mPa s at 20 C, 0.8900 mPa s at 25 C (IAPWS); air: 1.204 kg/m3, 18.1 uPa s.
    const Fluid water = fluid_at(FluidName::water, 20.0), air = fluid_at(FluidName::air, 20.0);
    EXPECT_NEAR(water.density_kg_per_m3, 998.21, 0.01);
    EXPECT_NEAR(water.viscosity_Pa_s, 1.0016e-3, 1e-7);
    EXPECT_NEAR(fluid_at(FluidName::water, 25.0).viscosity_Pa_s, 0.8900e-3, 1e-7);
    EXPECT_NEAR(fluid_at(FluidName::water, 100.0).density_kg_per_m3, 958.4, 0.1);
    EXPECT_NEAR(air.density_kg_per_m3, 1.204, 1e-3);
    EXPECT_NEAR(air.viscosity_Pa_s, 18.1e-6, 1e-7);
    EXPECT_NEAR(hydraulic_conductivity_m_per_s(1e-9, water), 1e-9 * 998.21 * 9.81 / 1.0016e-3, 1e-6);
    EXPECT_NEAR(carman_kozeny_m2(0.53, 0.0111867, 0.7, 150.0), 0.2809 * 1.25142e-4 * 0.343 / 13.5, 1e-11);
    EXPECT_NEAR(paper_fit_m2(0.7) / 8.784e-7, 1.0, 1e-3);
    // Ergun by hand: 0.7^3 * 0.53 * 0.0111867 / (1.75 * 0.3).
    EXPECT_NEAR(ergun_inertial_m(0.53, 0.0111867, 0.7) / 3.87358e-3, 1.0, 1e-5);
    // One darcy: 1 mPa s and 1 cm/s at 1 atm per cm.
    EXPECT_NEAR(darcy_m2 / (1e-3 * 1e-2 * 1e-2 / 101325.0), 1.0, 1e-6);
}

// Flows that obey Forchheimer's law, and flows of weak inertia: what lies between two of them is known, and the interval holds it.
TEST(PressureDrop, IsThatOfTheFlowsItComesFrom) {
    const double k = 1e-8, b = 0.02;
    const auto flows_of = [&](auto excess, std::initializer_list<double> reynolds) {
        InertialCurve curve{.permeability_m2 = k, .flows = {}};
        for (const double re : reynolds) curve.flows.push_back({re, k / (1.0 + excess(re)), 1e-4});
        return curve;
    };
    const auto straight = [&](double re) { return b * re; };
    const auto weak = [&](double re) { return 1e-3 * re * re; };
    for (const double re : {0.5, 2.0, 3.3, 7.0, 19.0, 20.0}) {
        const InertialFactor one = inertial_factor(flows_of(straight, {2, 5, 10, 20}), {}, re);
        EXPECT_NEAR(one.value, 1.0 + b * re, 1e-12 + one.half_width * one.value) << re;
        if (re >= 2.0) EXPECT_NEAR(one.value, 1.0 + b * re, 1e-12) << re;
        const InertialFactor other = inertial_factor(flows_of(weak, {2, 5, 10, 20}), {}, re);
        EXPECT_NEAR(other.value, 1.0 + weak(re), 1e-12 + other.half_width * other.value) << re;
        EXPECT_LT(other.half_width, 0.03) << re;
    }
    // The change to a coarser grid is part of the interval.
    const InertialFactor rough =
        inertial_factor(flows_of(straight, {2, 5, 10, 20}), flows_of([](double re) { return 0.025 * re; }, {2, 5, 10, 20}), 10.0);
    EXPECT_NEAR(rough.half_width, 0.05 / 1.2, 1e-3);
    // A coarser grid that ends at Re 10 is compared there; beyond, its change grows in proportion to Re: 1.25 / 1.2 - 1, twice.
    const InertialFactor beyond =
        inertial_factor(flows_of(straight, {2, 5, 10, 20}), flows_of([](double re) { return 0.025 * re; }, {2, 5, 10}), 20.0);
    EXPECT_NEAR(beyond.half_width, 2.0 * 0.05 / 1.2, 1e-3);
    // Weak inertia: four times.
    const InertialFactor quadratic =
        inertial_factor(flows_of(weak, {2, 5, 10, 20}), flows_of([](double re) { return 1.2e-3 * re * re; }, {2, 5, 10}), 20.0);
    EXPECT_NEAR(quadratic.half_width, 4.0 * 0.02 / 1.1, 1e-3);
    EXPECT_TRUE(test::has(test::message_of<core::UserError>([&] {
                              (void)inertial_factor(flows_of(straight, {2, 5, 10}), {}, 11.0);
                          }),
                          "up to 10"));
    // By hand: mu U / k.
    const Fluid fluid{.density_kg_per_m3 = 1000.0, .viscosity_Pa_s = 1e-3};
    const PressureGradient gradient = pressure_gradient(0.01, fluid, k, {0.9 * k, 1.1 * k}, {.value = 1.5, .half_width = 0.05});
    EXPECT_NEAR(gradient.value, 1500.0, 1e-9);
    EXPECT_NEAR(gradient.interval.low, 1500.0 * (1.0 - std::hypot(1.0 - 1.0 / 1.1, 0.05)), 1e-9);
    EXPECT_NEAR(gradient.interval.high, 1500.0 * (1.0 + std::hypot(1.0 / 0.9 - 1.0, 0.05)), 1e-9);
    // Spheres of 1 mm at a porosity of 0.4, Re = 10 / 0.6: Ergun by hand.
    const double unit = 1e-3 * 0.01 * 0.36 / (1e-6 * 0.064);
    EXPECT_NEAR(ergun_gradient(0.01, fluid, 1e-3, 0.4), (150.0 + 1.75 * 10.0 / 0.6) * unit, 1e-9);
    EXPECT_NEAR(erdim_gradient(0.01, fluid, 1e-3, 0.4), (160.0 + 2.81 * std::pow(10.0 / 0.6, 0.904)) * unit, 1e-9);
}

}  // namespace
}  // namespace porepack
