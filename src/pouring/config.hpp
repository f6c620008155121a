// Table [packing] of case.toml.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "record/config.hpp"

namespace porepack::pouring {

/// Source of the packing: the built-in DEM of exact shapes, LIGGGHTS with clumps of spheres, or none (a given file).
enum class Engine { capsule, liggghts, none };
constexpr std::array<core::Choice<Engine>, 3> choices_of(Engine) {
    return {{{Engine::capsule, "capsule"}, {Engine::liggghts, "liggghts"}, {Engine::none, "none"}}};
}
enum class Fill { batches, lattice, scatter };
constexpr std::array<core::Choice<Fill>, 3> choices_of(Fill) {
    return {{{Fill::batches, "batches"}, {Fill::lattice, "lattice"}, {Fill::scatter, "scatter"}}};
}
/// Velocity Verlet, second order and symplectic without damping; or the paper's third-order Adams-Bashforth (Eq. 3-8).
enum class Integrator { verlet, adams_bashforth };
constexpr std::array<core::Choice<Integrator>, 2> choices_of(Integrator) {
    return {{{Integrator::verlet, "verlet"}, {Integrator::adams_bashforth, "adams_bashforth"}}};
}
/// The part of the normal force that limits Coulomb friction: all of it, or its elastic part (the paper).
enum class FrictionLimit { total, elastic };
constexpr std::array<core::Choice<FrictionLimit>, 2> choices_of(FrictionLimit) {
    return {{{FrictionLimit::total, "total"}, {FrictionLimit::elastic, "elastic"}}};
}

/// Meaning, unit, range and default of each key: see describe(). 0 stands for "chosen automatically" where that is allowed.
struct PackingConfig {
    Engine engine = Engine::capsule;
    std::string file = {};
    Fill fill = Fill::batches;
    long seed = 1;
    long grains = 0;
    double fill_height_m = 0.0;
    double surface_tolerance = 0.05;
    long clump_spheres = 0;
    double density_kg_per_m3 = 1000.0;
    double gravity_m_per_s2 = 9.81;
    double normal_stiffness_N_per_m = 10000.0;
    double tangential_stiffness_N_per_m = 5000.0;
    double normal_damping = 0.35;
    double tangential_damping = 0.3;
    double friction = 0.35;
    double wall_friction = 0.1;
    double friction_uncertainty = 0.0;
    double time_step_s = 0.0;
    double drop_height_m = 0.0;
    long batch_grains = 9;
    double batch_interval_s = 0.11;
    double horizontal_speed_m_per_s = 0.5;
    double rest_energy_fraction = 1e-6;
    double settle_time_s = 5.0;
    long processes = 1;
    Integrator integrator = Integrator::verlet;
    FrictionLimit friction_limit = FrictionLimit::total;
    bool sleep = true;
    double snapshot_interval_s = 1.0;
};

inline void describe(record::ConfigVisitor& v, PackingConfig& c) {
    v.choice("engine", c.engine,
             "how the packing is made; capsule: built-in DEM of exact shapes; liggghts: clumps of spheres; none: read from `file`");
    v.text("file", c.file, "a given packing.json or packing.json.gz (engine = \"none\"), relative to the case");
    v.choice("fill", c.fill,
             "batches: grains fall from drop_height_m, batch after batch (batch_grains = 1: one grain at a time); lattice: all grains fall "
             "at once from a loose lattice above the floor; scatter: all grains at random places of a box that is periodic along x, y and "
             "z, without "
             "weight, for a step `compress` of [protocol]");
    v.integer("seed", c.seed, record::between(0, 2147483647), "seed of all random poses");
    v.moved_to("packings", "seeds");
    v.integer("grains", c.grains, {.low = 0, .high = 1e6, .zero_is_auto = true},
              "number of grains; auto: grains are added until the bed reaches fill_height_m");
    v.number("fill_height_m", c.fill_height_m, record::positive_or_auto(),
             "height at which pouring stops; auto: half the container's height");
    v.number("surface_tolerance", c.surface_tolerance, {.low = 0.0005, .high = 0.4},
             "liggghts: maximum distance between the sphere clump's surface and the exact one, as a fraction of the capsule's diameter, or "
             "of the thickness of a grain with faces");
    v.integer("clump_spheres", c.clump_spheres, {.low = 1, .high = 10000, .zero_is_auto = true},
              "liggghts: maximum number of spheres per clump; auto: as many as surface_tolerance needs");
    v.number("density_kg_per_m3", c.density_kg_per_m3, record::between(1.0, 1e5), "density of the grains");
    v.number("gravity_m_per_s2", c.gravity_m_per_s2, record::between(1e-3, 1e4), "gravity, along -z");
    v.number("normal_stiffness_N_per_m", c.normal_stiffness_N_per_m, record::positive(),
             "s_n of Eq. 9; the contact stiffness is s_n/2. Twice the value: half the overlap, and a time step shorter by 1.4");
    v.number("tangential_stiffness_N_per_m", c.tangential_stiffness_N_per_m, record::positive(), "s_t; the contact stiffness is s_t/2");
    v.number("normal_damping", c.normal_damping, record::between(0.0, 0.99),
             "eta_n of Eq. 9, a fraction of critical damping; 0: the grains rebound without loss");
    v.number("tangential_damping", c.tangential_damping, record::between(0.0, 0.99), "eta_t, the same along the contact plane");
    v.number("friction", c.friction, record::between(0.0, 10.0), "Coulomb friction between grains");
    v.number("wall_friction", c.wall_friction, record::between(0.0, 10.0), "Coulomb friction at the walls");
    v.number(
        "friction_uncertainty", c.friction_uncertainty, record::between(0.0, 5.0),
        "standard uncertainty of `friction`: it varies between the packings of [packings], evenly within sqrt(3) times this value, and "
        "its effect on k becomes a row of the budget; 0: friction is taken as known");
    v.number("time_step_s", c.time_step_s, record::positive_or_auto(),
             "time step; auto: the contact time / 45, or 0.06 / the rate of the stronger dashpot if that is smaller; shorter by "
             "sqrt(n / 6) for grains of n > 6 capsules, which have many contacts at once, and by sqrt(2) for grains with faces; by "
             "sqrt(n / 12) for clumps of n > 24 spheres of such grains");
    v.number("drop_height_m", c.drop_height_m, record::positive_or_auto(),
             "height above the floor at which grains are created; auto: one maximum Feret diameter below the rim");
    v.integer("batch_grains", c.batch_grains, record::between(1, 10000), "grains created together; fewer when not all fit without overlap");
    v.number("batch_interval_s", c.batch_interval_s, record::between(1e-4, 1e3), "time between two batches");
    v.number("horizontal_speed_m_per_s", c.horizontal_speed_m_per_s, record::between(0.0, 100.0),
             "each horizontal velocity component is random within +- this value");
    v.number("rest_energy_fraction", c.rest_energy_fraction, {.low = 1e-12, .high = 0.1},
             "criterion for rest: the kinetic energy per grain is below this fraction of m g d (m: mass of a grain, g: gravity, d: "
             "smallest diameter of the capsules, or thickness of a grain with faces)");
    v.number("settle_time_s", c.settle_time_s, record::between(1e-4, 1e4),
             "maximum simulated time after the last batch, and after each time that all grains are woken");
    v.integer("processes", c.processes, record::between(1, 256),
              "MPI processes of LIGGGHTS; another number gives another, statistically equivalent packing");
    v.choice("integrator", c.integrator, "capsule: verlet, of second order; or the paper's Adams-Bashforth, of third order");
    v.choice("friction_limit", c.friction_limit,
             "capsule: friction is limited by the whole normal force, or by its elastic part (the paper)");
    v.boolean("sleep", c.sleep, "engine capsule: grains at rest are not computed until the force on one of their contacts changes");
    v.number("snapshot_interval_s", c.snapshot_interval_s, record::between(1e-3, 1e6),
             "simulated time between snapshots, from which an interrupted run resumes");
}

/// The part of the bed whose porosity was measured: the section of k; the bed from the floor to its highest grain; or between two levels.
enum class MeasuredPart { section, bed, between };
constexpr std::array<core::Choice<MeasuredPart>, 3> choices_of(MeasuredPart) {
    return {{{MeasuredPart::section, "section"}, {MeasuredPart::bed, "bed"}, {MeasuredPart::between, "between"}}};
}

/// Table [packings]: several packings of one case, with consecutive seeds.
struct PackingsConfig {
    long seeds = 1;
    double until_sure = 0.0;
    long max_packings = 200;
    double max_time_s = 0.0;
    long pours_per_flow = 8;
    std::vector<double> measured_porosity = {};
    MeasuredPart measured_part = MeasuredPart::section;
    std::vector<double> measured_between_m = {};
    [[nodiscard]] bool several() const { return seeds > 1 || until_sure > 0.0; }
};

inline void describe(record::ConfigVisitor& v, PackingsConfig& c) {
    v.moved_here("packing", "seeds");
    v.integer("seeds", c.seeds, record::between(1, 1000),
              "number of packings, with consecutive seeds: porosity, tortuosities and permeability of each are computed, and their scatter "
              "is reported");
    v.number("until_sure", c.until_sure, {.low = 0.005, .high = 0.5, .zero_is_auto = true},
             "packings are added (at least 6; with pours_per_flow = 1, 5) until the 95 % interval of the mean permeability is within this "
             "fraction of it, numerical "
             "part included; auto: `seeds` packings");
    v.integer("max_packings", c.max_packings, record::between(5, 1000), "until_sure: maximum number of packings whose flow is computed");
    v.number("max_time_s", c.max_time_s, {.low = 1.0, .high = 1e9, .zero_is_auto = true},
             "until_sure: seconds after which no further packing is begun; auto: no limit");
    v.integer(
        "pours_per_flow", c.pours_per_flow, record::between(1, 100),
        "until_sure: pours for each computed flow. Only their porosity is used: it tells most of their k. 1: the flow of each pour is "
        "computed, for grains whose pour takes as long as the flow");
    v.numbers("measured_porosity", c.measured_porosity, {2, 2}, {.low = 0.0, .high = 1.0},
              "porosity of a bed that exists, and its standard uncertainty: k of this bed is estimated from the packings (5 or more)");
    v.choice("measured_part", c.measured_part,
             "of which part it was measured: the section of k; the whole bed, from the floor to the highest grain; or between two levels");
    v.numbers("measured_between_m", c.measured_between_m, {2, 2}, record::between(0.0, 1e6),
              "measured_part = \"between\": the two levels above the floor");
}

}  // namespace porepack::pouring
