// The causes: what is uncertain in a falling-head test, with ranges and their sources. The ranges were written down before all causes
// were drawn together for the first time.
#include "falling_head/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "falling_head/falling_head.hpp"

namespace porepack::falling_head {
namespace {

constexpr double surface_tension = 0.0728, water_density = 998.2, capillary_length_m = 2.73e-3;  // N/m, kg/m3, of water at 20 C

using Causes = std::vector<UncertainCause>;

void multiply(Resistance& resistance, double viscous, double inertial) {
    resistance.inverse_permeability_per_m2 *= viscous;
    resistance.inverse_inertial_permeability_per_m *= inertial;
}

double middle_speed(const SampleTruth& truth, const FallingHeadConfig& config) {
    return FallingHead(truth.permeability_m2, truth.inertial_permeability_m, config)
        .speed_at(0.5 * (config.window_m[0] + config.window_m[1]));
}

void add_laws_of_flow(Causes& causes, const SampleTruth& truth, const FallingHeadConfig& config) {
    const double reference = truth.largest_reynolds * config.kinematic_viscosity_m2_per_s / truth.grain_diameter_m;
    causes.push_back(
        {.name = "falling inertial coefficient",
         .what = fmt::format("1/k_in falls like Re^-n above Re = {:.0f}, the largest that was computed", truth.largest_reynolds),
         .low = 0.0,
         .high = 0.2,
         .source =
             "n: Ergun 1952 0; Carman 1937 and KTA 3102.3 0.1; Tallmadge 1970 1/6; Hicks 1970 0.2 (of the total loss: an upper bound)",
         .apply =
             [reference](Scenario& s, double n) {
                 s.apparatus.inertial_exponent = n;
                 s.apparatus.inertial_reference_speed_m_per_s = reference;
             },
         .minimum = 0.0,
         .maximum = 0.8,
         .common = true});
    causes.push_back({.name = "turbulent viscous term",
                      .what = "part of the change of both coefficients from Forchheimer's regime to turbulence: 1/k x 1.24, 1/k_in x 0.84",
                      .low = 0.0,
                      .high = 1.0,
                      .source = "Fand, Kim, Lam & Phan 1987 (spheres)",
                      .apply = [](Scenario& s, double part) { multiply(s.resistance, 1.0 + 0.24 * part, 1.0 - 0.16 * part); },
                      .minimum = -1.0,
                      .common = true});
}

void add_structure_of_the_sample(Causes& causes, const SampleTruth& truth, const FallingHeadConfig& config) {
    const double straight = 1.0 / truth.porosity, usual = std::max(straight, inertia_coefficient(config));
    causes.push_back({.name = "inertia of the water",
                      .what = "inertia coefficient m of the sample",
                      .low = straight,
                      .high = std::max(usual, truth.quasi_steady_inertia.value_or(usual)),
                      .source = truth.quasi_steady_inertia ? "1/porosity; <u^2>/(porosity <u_z>^2) of the computed flow"
                                                           : "1/porosity; tortuosity factor / porosity",
                      .apply =
                          [](Scenario& s, double m) {
                              s.apparatus.column_inertia = true;
                              s.apparatus.inertia_coefficient = m;
                          },
                      .absent = std::nullopt,
                      .minimum = 1.0});
    causes.push_back({.name = "structure at the ends",
                      .what = "share of the change of 1/k and 1/k_in by the packing's porosity profile",
                      .low = 0.5,
                      .high = 1.5,
                      .source = "porosity profile; Carman-Kozeny and Ergun for each layer",
                      .judged = true,
                      .apply =
                          [=](Scenario& s, double share) {
                              multiply(s.resistance, 1.0 + share * (truth.ends_viscous - 1.0), 1.0 + share * (truth.ends_inertial - 1.0));
                          },
                      .absent = std::nullopt,
                      .minimum = 0.0});
    causes.push_back({.name = "grains aligned at the wire screen",
                      .what = "share of a lowest layer, one grain high, that is 0.1 less porous",
                      .low = 0.0,
                      .high = 1.0,
                      .source = "the paper saw alignment, without a figure",
                      .judged = true,
                      .apply =
                          [=](Scenario& s, double share) {
                              multiply(s.resistance, 1.0 + share * (truth.aligned_viscous - 1.0),
                                       1.0 + share * (truth.aligned_inertial - 1.0));
                          },
                      .minimum = 0.0});
    causes.push_back({.name = "trapped gas",
                      .what = "part of the pore volume; k and k_in x (1 - s)^3",
                      .low = 0.0,
                      .high = 0.03,
                      .source = "exponent of k: Irmay 1954; the same for k_in, and amount",
                      .judged = true,
                      .apply =
                          [](Scenario& s, double gas) {
                              const double open = std::pow(1.0 - gas, -3.0);
                              multiply(s.resistance, open, open);
                          },
                      .minimum = 0.0,
                      .maximum = 0.5});
}

void add_screens(Causes& causes, const FallingHeadConfig& config) {
    const double wire = config.screen_wire_m > 0.0 ? config.screen_wire_m : 0.2 * config.screen_opening_m;
    const auto screens = [config](Scenario& s) {
        s.apparatus.screen_opening_m = config.screen_opening_m;
        s.apparatus.screens_below = config.screens_below;
        s.apparatus.screens_above = config.screens_above;
        // Another cause may have drawn the wires already.
        if (s.apparatus.screen_wire_m == 0.0)
            s.apparatus.screen_wire_m = config.screen_wire_m > 0.0 ? config.screen_wire_m : 0.2 * config.screen_opening_m;
    };
    causes.push_back({.name = "wire screens",
                      .what = fmt::format("diameter of their wires; {} below, {} on top", config.screens_below, config.screens_above),
                      .unit = "m",
                      .low = 0.5 * wire,
                      .high = wire,
                      .source = "loss: Idelchik, diagram 8-6; wires",
                      .judged = true,
                      .apply =
                          [screens](Scenario& s, double wires) {
                              s.apparatus.screen_wire_m = wires;
                              screens(s);
                          },
                      .absent = std::nullopt,
                      .minimum = 0.05 * wire,
                      .common = true});
    causes.push_back({.name = "screen below partly covered",
                      .what = "part of its openings that grains cover",
                      .low = 0.0,
                      .high = 0.5,
                      .source = "grains reach into the openings; part",
                      .judged = true,
                      .apply =
                          [screens](Scenario& s, double covered) {
                              screens(s);
                              s.apparatus.screen_free_fraction = 1.0 - covered;
                          },
                      .minimum = 0.0,
                      .maximum = 0.9});
}

void add_inlet_and_outlet(Causes& causes, const FallingHeadConfig& config) {
    if (config.loss_coefficient > 0.0)
        causes.push_back({.name = "inlet and outlet",
                          .what = "loss coefficient",
                          .low = 0.5 * config.loss_coefficient,
                          .high = 1.5 * config.loss_coefficient,
                          .source = "half of the given value, up and down",
                          .judged = true,
                          .apply = [](Scenario& s, double loss) { s.apparatus.loss_coefficient = loss; },
                          .absent = std::nullopt,
                          .minimum = 0.0,
                          .common = true});
}

void add_opening(Causes& causes, const FallingHeadConfig& config) {
    // The outlet must be open before the level enters the window.
    const double latest = std::max(config.window_m[0], config.window_m[1]) + 0.02;
    if (config.start_level_m > latest)
        causes.push_back({.name = "opening of the outlet",
                          .what = "level at which the outlet is open; with the inertia of the water",
                          .unit = "m",
                          .low = std::max(latest, config.start_level_m - 0.2),
                          .high = config.start_level_m,
                          .source = "opened within some tenths of a second",
                          .judged = true,
                          .apply =
                              [](Scenario& s, double level) {
                                  s.apparatus.column_inertia = true;
                                  s.apparatus.start_level_m = level;
                              },
                          .absent = config.start_level_m,
                          .minimum = latest});
}

// Friction, films and jets at the walls of the column.
void add_walls(Causes& causes, const SampleTruth& truth, const FallingHeadConfig& config) {
    const double speed = middle_speed(truth, config), nu = config.kinematic_viscosity_m2_per_s, D = truth.tube_diameter_m;
    // Blasius' friction factor of smooth tubes at the middle of the window.
    const double friction = 0.316 * std::pow(speed * D / nu, -0.25) / D;
    causes.push_back({.name = "friction on the tube's wall",
                      .what = "friction factor over diameter",
                      .unit = "1/m",
                      .low = 0.0,
                      .high = 1.5 * friction,
                      .source = "Blasius 1913; 1.5 times for a flow that still develops",
                      .judged = true,
                      .apply = [](Scenario& s, double value) { s.apparatus.column_friction_per_m = value; },
                      .minimum = 0.0,
                      .common = true});
    // A film of thickness t covers 4 t / D of the area. The speed in the sample is then (1 - part) times that of the level. In terms of the
    // level's speed, the viscous resistance shrinks by this factor and the inertial one by its square.
    const double film = 0.94 * capillary_length_m * std::pow(water_density * nu * speed / surface_tension, 2.0 / 3.0);
    causes.push_back({.name = "water left on the tube's wall",
                      .what = "part of the tube's area",
                      .low = 0.0,
                      .high = 4.0 * film / D,
                      .source = "Landau & Levich 1942, at the middle of the window, beyond their small capillary numbers",
                      .judged = true,
                      .apply = [](Scenario& s, double part) { multiply(s.resistance, 1.0 - part, (1.0 - part) * (1.0 - part)); },
                      .minimum = 0.0,
                      .maximum = 0.5,
                      .common = true});
    // Surface tension raises the pressure in a cylindrical jet by sigma / r, which acts against the head.
    const double radius = config.screen_opening_m > 0.0 ? 0.5 * config.screen_opening_m : 4e-3;
    causes.push_back({.name = "pressure in the jets below",
                      .what = "as a height of water that the head lacks",
                      .unit = "m",
                      .low = 0.0,
                      .high = surface_tension / (radius * water_density * config.gravity_m_per_s2),
                      .source = fmt::format("Laplace 1806, jets of {:g} mm radius", 1e3 * radius),
                      .apply = [](Scenario& s, double height) { s.apparatus.level_offset_m -= height; },
                      .minimum = 0.0,
                      .common = true});
}

void add_readings(Causes& causes, const FallingHeadConfig& config) {
    // Added, not set: several causes act on the same reading.
    const auto offset = [](Scenario& s, double metres) { s.apparatus.level_offset_m += metres; };
    const auto scale = [](Scenario& s, double part) { s.apparatus.scale_error += part; };
    causes.push_back({.name = "zero of the level",
                      .what = "true level minus measured level",
                      .unit = "m",
                      .low = -2e-3,
                      .high = 2e-3,
                      .source = "reading of a ruler against the edge of a bed of grains",
                      .judged = true,
                      .apply = offset});
    causes.push_back({.name = "edge of the meniscus",
                      .what = "the upper edge is read, above the flat level",
                      .unit = "m",
                      .low = 0.0,
                      .high = capillary_length_m * std::sqrt(2.0 * (1.0 - std::sin(50.0 / 180.0 * 3.14159265358979))),
                      .source = "Batchelor 1967; receding contact angle of 50 degrees on acrylic",
                      .judged = true,
                      .apply = [offset](Scenario& s, double height) { offset(s, -height); },
                      .minimum = 0.0,
                      .common = true});
    causes.push_back({.name = "scale",
                      .what = "true distances are longer, about the middle of the window",
                      .low = -0.003,
                      .high = 0.003,
                      .source = "printed scale, distortion of the lens",
                      .judged = true,
                      .apply = scale,
                      .common = true});
    causes.push_back({.name = "parallax",
                      .what = "distance from the scale to the meniscus over that of the camera, at the height of the middle",
                      .low = -0.025 / 3.0,
                      .high = 0.025 / 3.0,
                      .source = "25 mm deep, seen from 3 m",
                      .judged = true,
                      .apply = scale,
                      .common = true});
    causes.push_back({.name = "sample length",
                      .what = "true minus assumed length; the level is read on a fixed scale",
                      .unit = "m",
                      .low = -5e-3,
                      .high = 5e-3,
                      .source = "half a grain",
                      .judged = true,
                      .apply =
                          [](Scenario& s, double longer) {
                              s.apparatus.sample_length_m += longer;
                              // A longer sample reaches higher on the scale, so the level above its top is lower.
                              s.apparatus.level_offset_m -= longer;
                          },
                      .minimum = -0.5 * config.sample_length_m});
    causes.push_back({.name = "temperature",
                      .what = "true temperature; evaluated with the viscosity at 20 C",
                      .unit = "C",
                      .low = 15.0,
                      .high = 25.0,
                      .source = "viscosity: Kestin, Sokolov & Wakeham 1978; \"room temperature\"",
                      .judged = true,
                      .apply = [](Scenario& s, double t) { s.apparatus.kinematic_viscosity_m2_per_s *= water_viscosity_ratio(t); },
                      .absent = 20.0,
                      .minimum = 0.0,
                      .maximum = 40.0,
                      .common = true});
    causes.push_back({.name = "noise of the frames",
                      .what = "standard deviation of each level",
                      .unit = "m",
                      .low = 0.0,
                      .high = 1e-3,
                      .source = "one pixel of a camera that sees 2 m",
                      .judged = true,
                      .apply = [](Scenario& s, double noise) { s.apparatus.noise_m = noise; },
                      .minimum = 0.0});
}

}  // namespace

double water_viscosity_ratio(double temperature_celsius) {
    const double below = 20.0 - temperature_celsius;
    return std::pow(10.0, below / (temperature_celsius + 96.0) * (1.2364 - 1.37e-3 * below + 5.7e-6 * below * below));
}

std::vector<UncertainCause> uncertain_causes(const SampleTruth& truth, const FallingHeadConfig& config) {
    Causes causes;
    add_laws_of_flow(causes, truth, config);
    add_structure_of_the_sample(causes, truth, config);
    if (config.screen_opening_m > 0.0) add_screens(causes, config);
    add_inlet_and_outlet(causes, config);
    add_walls(causes, truth, config);
    add_opening(causes, config);
    add_readings(causes, config);
    return causes;
}

ProfileFactors profile_factors(const std::vector<double>& layers, double central) {
    ProfileFactors factors{0.0, 0.0};
    const auto cube = [](double e) { return e * e * e; };
    for (const double e : layers) {
        factors.viscous += (1.0 - e) * (1.0 - e) / cube(e);
        factors.inertial += (1.0 - e) / cube(e);
    }
    const auto count = static_cast<double>(layers.size());
    factors.viscous *= cube(central) / ((1.0 - central) * (1.0 - central)) / count;
    factors.inertial *= cube(central) / (1.0 - central) / count;
    return factors;
}

}  // namespace porepack::falling_head
