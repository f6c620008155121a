// Tables [forchheimer] and [falling_head] of case.toml.
#pragma once

#include "core/config.hpp"

namespace porepack {

struct ForchheimerConfig {
    bool enabled = false;
    std::vector<double> reynolds = {2, 5, 10, 20, 40, 80};
    double voxel_size_m = 0.0;
    long grids = 2;
    double grid_ratio = 1.5;
    double tolerance = 1e-3;
    long max_steps = 100000;
    bool openfoam = true;
    double cell_size_m = 0.0;
    long surface_level = 1;
    double relaxation_velocity = 0.8;
    double relaxation_pressure = 0.2;
    double residual = 1e-5;
    long max_iterations = 2000;
    long processes = 1;
};

inline void describe(ConfigVisitor& v, ForchheimerConfig& c) {
    v.boolean("enabled", c.enabled, "flows with inertia: permeability against the Reynolds number, and from it the inertial permeability");
    v.numbers("reynolds", c.reynolds, {3, 100}, {.low = 1e-3, .high = 1e4},
              "Reynolds numbers U d/nu, rising (U superficial velocity, d diameter of the sphere of a grain's volume); the first without a "
              "steady flow ends the series");
    v.number("voxel_size_m", c.voxel_size_m, length_or_auto(), "finest grid; auto: the smallest capsule diameter / 8");
    v.integer("grids", c.grids, between(1, 3), "two or more: the change between the finest two is the error of the grid");
    v.number("grid_ratio", c.grid_ratio, {.low = 1.1, .high = 4.0}, "voxel size of a grid / that of the next finer one");
    v.number("tolerance", c.tolerance, {.low = 1e-8, .high = 0.1},
             "relative iteration error of the permeability at which a flow is steady");
    v.integer("max_steps", c.max_steps, {.low = 1, .high = 1e9}, "a flow that is not steady after as many time steps has no number");
    v.boolean("openfoam", c.openfoam, "the same flows by OpenFOAM too");
    v.number("cell_size_m", c.cell_size_m, length_or_auto(), "OpenFOAM's background cell; auto: the smallest capsule diameter / 4");
    v.integer("surface_level", c.surface_level, between(0, 3), "OpenFOAM's cells at grains and wall are 2^level times finer");
    v.number("relaxation_velocity", c.relaxation_velocity, {.low = 0.1, .high = 0.99}, "OpenFOAM's relaxation of U");
    v.number("relaxation_pressure", c.relaxation_pressure, {.low = 0.01, .high = 0.99}, "OpenFOAM's relaxation of p");
    v.number("residual", c.residual, {.low = 1e-12, .high = 1e-2}, "OpenFOAM's residual of U and p at which a flow is steady");
    v.integer("max_iterations", c.max_iterations, between(2, 1000000), "a flow that is not steady after as many iterations has no number");
    v.integer("processes", c.processes, between(1, 256), "of OpenFOAM's solver (mpirun)");
}

struct FallingHeadConfig {
    double sample_length_m = 0.12;
    double start_level_m = 1.6;
    std::vector<double> levels_m = {1.3, 0.7, 0.1};
    std::vector<double> window_m = {0.1, 1.3};
    double kinematic_viscosity_m2_per_s = 1e-6;
    double gravity_m_per_s2 = 9.81;
    bool column_inertia = true;
    double sample_inertia = 0.0;
    double mesh_opening_m = 0.0;
    double mesh_wire_m = 0.0;
    long meshes_below = 1;
    long meshes_above = 1;
    double mesh_free_share = 1.0;
    double loss_coefficient = 0.0;
    double level_offset_m = 0.0;
    double level_offset_uncertainty_m = 0.0;
    double noise_m = 0.0;
    double frames_per_s = 50.0;
    long seed = 1;
    bool causes = false;
    double computed_over_measured = 0.0;
};

inline void describe(ConfigVisitor& v, FallingHeadConfig& c) {
    v.number("sample_length_m", c.sample_length_m, length(), "length of the sample, L of Eq. 18");
    v.number("start_level_m", c.start_level_m, length(), "water level above the sample at time 0, when the outlet is opened");
    v.numbers("levels_m", c.levels_m, {1, 1000}, not_negative(), "levels whose times are asked for");
    v.numbers("window_m", c.window_m, {2, 2}, not_negative(), "lowest and highest level of a measured curve that is evaluated");
    v.number("kinematic_viscosity_m2_per_s", c.kinematic_viscosity_m2_per_s, positive(), "of the liquid");
    v.number("gravity_m_per_s2", c.gravity_m_per_s2, positive(), "gravity");
    v.boolean("column_inertia", c.column_inertia,
              "the water's inertia: it starts at rest, and its column above the sample has to be slowed down");
    v.number("sample_inertia", c.sample_inertia, {.low = 1.0, .high = 100.0, .zero_is_auto = true},
             "the water in the sample moves like a column of so many sample lengths: diffusive tortuosity / porosity; auto: that of the "
             "case where it has been computed, else porosity^-1.5 where that is known, else 1.5");
    v.number("mesh_opening_m", c.mesh_opening_m, length_or_auto(), "opening of the wire meshes that hold the sample; auto: no mesh");
    v.number("mesh_wire_m", c.mesh_wire_m, length_or_auto(), "diameter of their wires; auto: a fifth of the opening");
    v.integer("meshes_below", c.meshes_below, between(0, 10), "meshes below the sample");
    v.integer("meshes_above", c.meshes_above, between(0, 10), "meshes on top of the sample");
    v.number("mesh_free_share", c.mesh_free_share, {.low = 0.01, .high = 1.0}, "share of the openings below that grains leave free");
    v.number("loss_coefficient", c.loss_coefficient, between(0.0, 1e6),
             "of inlet and outlet together: they take so many times v^2/2 (v: speed of the level)");
    v.number("level_offset_m", c.level_offset_m, between(-1.0, 1.0), "true level less measured level");
    v.number("level_offset_uncertainty_m", c.level_offset_uncertainty_m, between(0.0, 1.0),
             "standard deviation of the offset; it then counts in the intervals of an analysis");
    v.number("noise_m", c.noise_m, between(0.0, 1.0), "standard deviation of the measured level, of a simulated curve");
    v.number("frames_per_s", c.frames_per_s, between(1e-3, 1e6), "pictures a second, of a simulated curve");
    v.integer("seed", c.seed, {.low = 0, .high = 1e9}, "of a simulated curve's noise");
    v.boolean("causes", c.causes, "of a case: how much each cause changes the k that the paper's evaluation gives");
    v.number("computed_over_measured", c.computed_over_measured, between(0.0, 1e6),
             "k computed / k measured, which the causes are to explain (the paper: 2.3 and 2.8); 0: nothing to explain");
}

}  // namespace porepack
