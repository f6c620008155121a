// Table [falling_head] of case.toml.
#pragma once

#include <vector>

#include "record/config.hpp"

namespace porepack::falling_head {

/// Meaning, unit, range and default of each key: see describe(). 0 means "chosen automatically" where that is allowed.
struct FallingHeadConfig {
    double sample_length_m = 0.12;
    double start_level_m = 1.6;
    std::vector<double> levels_m = {1.3, 0.7, 0.1};
    std::vector<double> window_m = {0.1, 1.3};
    double kinematic_viscosity_m2_per_s = 1e-6;
    double gravity_m_per_s2 = 9.81;
    bool column_inertia = true;
    double inertia_coefficient = 0.0;
    double screen_opening_m = 0.0;
    double screen_wire_m = 0.0;
    long screens_below = 1;
    long screens_above = 1;
    double screen_free_fraction = 1.0;
    double loss_coefficient = 0.0;
    double column_friction_per_m = 0.0;
    double inertial_exponent = 0.0;
    double inertial_reference_speed_m_per_s = 0.0;
    double level_offset_m = 0.0;
    double scale_error = 0.0;
    double level_offset_uncertainty_m = 0.0;
    double scale_uncertainty = 0.0;
    double viscosity_uncertainty = 0.0;
    double inertia_coefficient_uncertainty = 0.0;
    double inertial_exponent_uncertainty = 0.0;
    double noise_m = 0.0;
    double frames_per_s = 50.0;
    long seed = 1;
    bool causes = false;
    double computed_over_measured = 0.0;
};

inline void describe(record::ConfigVisitor& v, FallingHeadConfig& c) {
    v.number("sample_length_m", c.sample_length_m, record::length_range(), "length of the sample, L of Eq. 18");
    v.number("start_level_m", c.start_level_m, record::length_range(), "water level above the sample at time 0, when the outlet is opened");
    v.numbers("levels_m", c.levels_m, {1, 1000}, record::not_negative(), "water levels for which times are computed");
    v.numbers("window_m", c.window_m, {2, 2}, record::not_negative(), "minimum and maximum water level for the evaluation of a curve");
    v.number("kinematic_viscosity_m2_per_s", c.kinematic_viscosity_m2_per_s, record::positive(), "kinematic viscosity of the liquid");
    v.number("gravity_m_per_s2", c.gravity_m_per_s2, record::positive(), "gravity");
    v.boolean("column_inertia", c.column_inertia,
              "include the inertia of the water: it starts at rest, and its column above the sample decelerates");
    v.renamed("sample_inertia", "inertia_coefficient");
    v.number("inertia_coefficient", c.inertia_coefficient, {.low = 1.0, .high = 100.0, .zero_is_auto = true},
             "m = tortuosity factor / porosity: the water in the sample has the inertia of a plain water column of length m times the "
             "sample length. Auto: the value from the tortuosity factor of the case if that has been computed, else porosity^-1.5 if the "
             "porosity is known, else 1.5");
    v.renamed("mesh_opening_m", "screen_opening_m");
    v.number("screen_opening_m", c.screen_opening_m, record::length_range_or_auto(),
             "opening of the wire screens that hold the sample; auto: no screen");
    v.renamed("mesh_wire_m", "screen_wire_m");
    v.number("screen_wire_m", c.screen_wire_m, record::length_range_or_auto(), "diameter of their wires; auto: a fifth of the opening");
    v.renamed("meshes_below", "screens_below");
    v.integer("screens_below", c.screens_below, record::between(0, 10), "number of wire screens below the sample");
    v.renamed("meshes_above", "screens_above");
    v.integer("screens_above", c.screens_above, record::between(0, 10), "number of wire screens on top of the sample");
    v.renamed("mesh_free_share", "screen_free_fraction");
    v.number("screen_free_fraction", c.screen_free_fraction, {.low = 0.01, .high = 1.0},
             "fraction of the openings below the sample that grains leave free");
    v.number("loss_coefficient", c.loss_coefficient, record::between(0.0, 1e6),
             "loss coefficient K of inlet and outlet together; the loss is K v^2/2 (v: speed of the water level)");
    v.number("column_friction_per_m", c.column_friction_per_m, record::between(0.0, 100.0),
             "friction of the water on the tube's wall: the friction factor over the tube's diameter; the loss is this times h v^2/2");
    v.number("inertial_exponent", c.inertial_exponent, record::between(0.0, 0.9),
             "n: above inertial_reference_speed_m_per_s, the inertial coefficient 1/k_in falls like the speed to the power of -n");
    v.number("inertial_reference_speed_m_per_s", c.inertial_reference_speed_m_per_s, record::between(0.0, 100.0),
             "speed at which k_in was found; with inertial_exponent");
    v.number("level_offset_m", c.level_offset_m, record::between(-1.0, 1.0), "true water level minus measured water level");
    v.number("scale_error", c.scale_error, record::between(-0.2, 0.2),
             "true distances between water levels are longer than the measured ones by this part, about the middle of the window");
    v.number("level_offset_uncertainty_m", c.level_offset_uncertainty_m, record::between(0.0, 1.0),
             "standard deviation of the offset; it is included in the intervals of an analysis");
    v.number("scale_uncertainty", c.scale_uncertainty, record::between(0.0, 0.1), "standard deviation of scale_error; likewise");
    v.number("viscosity_uncertainty", c.viscosity_uncertainty, record::between(0.0, 0.5),
             "standard deviation of the viscosity, relative (2.4 % per degree of water at 20 C); likewise");
    v.number("inertia_coefficient_uncertainty", c.inertia_coefficient_uncertainty, record::between(0.0, 10.0),
             "standard deviation of inertia_coefficient; likewise");
    v.number("inertial_exponent_uncertainty", c.inertial_exponent_uncertainty, record::between(0.0, 0.5),
             "standard deviation of inertial_exponent; likewise; needs inertial_reference_speed_m_per_s");
    v.number("noise_m", c.noise_m, record::between(0.0, 1.0), "standard deviation of the measured water level of a simulated curve");
    v.number("frames_per_s", c.frames_per_s, record::between(1e-3, 1e6), "frames per second of a simulated curve");
    v.integer("seed", c.seed, {.low = 0, .high = 1e9}, "seed of the noise of a simulated curve");
    v.boolean("causes", c.causes, "in a case: compute how much each possible cause changes the k that the paper's evaluation gives");
    v.number("computed_over_measured", c.computed_over_measured, record::between(0.0, 1e6),
             "k computed / k measured, to be explained by the causes (the paper: 2.3 and 2.8); 0: nothing to explain");
}

}  // namespace porepack::falling_head
