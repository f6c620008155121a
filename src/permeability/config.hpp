// Table [forchheimer] of case.toml.
#pragma once

#include <string>
#include <vector>

#include "record/config.hpp"

namespace porepack::permeability {

/// Meaning, unit, range and default of each key: see describe(). 0 means "chosen automatically" where that is allowed.
struct ForchheimerConfig {
    bool enabled = false;
    std::vector<double> reynolds = {2, 5, 10, 20, 40, 80};
    std::string device = "cpu";
    double voxel_size_m = 0.0;
    long grids = 2;
    double grid_ratio = 1.5;
    double tolerance = 1e-3;
    long max_steps = 100000;
    bool mean_in_time = false;
    double statistical_tolerance = 0.02;
    double max_turnovers = 800.0;
    bool openfoam = true;
    double cell_size_m = 0.0;
    long surface_level = 1;
    double relaxation_velocity = 0.8;
    double relaxation_pressure = 0.2;
    double residual = 1e-5;
    long max_iterations = 2000;
    long processes = 1;
};

inline void describe(record::ConfigVisitor& v, ForchheimerConfig& c) {
    v.boolean("enabled", c.enabled,
              "compute flows with inertia: the permeability as a function of the Reynolds number, and from it the inertial permeability");
    v.numbers("reynolds", c.reynolds, {3, 100}, {.low = 1e-3, .high = 1e4},
              "Reynolds numbers U d/nu, increasing (U: superficial velocity, d: diameter of the sphere with the volume of a grain); the "
              "series ends at the first Reynolds number without a steady flow");
    v.text("device", c.device, "what computes the flows by lattice Boltzmann, as in [lbm]");
    v.number("voxel_size_m", c.voxel_size_m, record::length_range_or_auto(),
             "voxel size of the finest grid; auto: the smallest thickness of the grains / 8, with mean_in_time / 16");
    v.integer("grids", c.grids, record::between(1, 3), "number of grids; two or more: the change between the finest two is the grid error");
    v.number("grid_ratio", c.grid_ratio, {.low = 1.1, .high = 4.0}, "voxel size of a grid / that of the next finer one");
    v.number("tolerance", c.tolerance, {.low = 1e-8, .high = 0.1},
             "relative iteration error of the permeability at which a flow is steady");
    v.integer("max_steps", c.max_steps, {.low = 1, .high = 1e9},
              "a flow that is not steady after this number of time steps gets no result");
    v.boolean(
        "mean_in_time", c.mean_in_time,
        "flows that are not steady: the mean velocity in time at each Reynolds number, with its statistical error; only in boxes that "
        "are periodic along z, and without OpenFOAM");
    v.number("statistical_tolerance", c.statistical_tolerance, {.low = 1e-4, .high = 0.5},
             "with mean_in_time: relative half width of the 95 % interval of the mean velocity at which a flow ends");
    v.number(
        "max_turnovers", c.max_turnovers, {.low = 40.0, .high = 1e6},
        "with mean_in_time: a flow whose mean is not known to the tolerance after this time ends the series; a turnover is the time in "
        "which the mean velocity in the pores passes one grain diameter");
    v.boolean("openfoam", c.openfoam, "compute the same flows by OpenFOAM as well");
    v.number("cell_size_m", c.cell_size_m, record::length_range_or_auto(),
             "size of OpenFOAM's background cells; auto: the smallest thickness of the grains / 4");
    v.integer("surface_level", c.surface_level, record::between(0, 3), "OpenFOAM's cells at grains and wall are 2^level times finer");
    v.number("relaxation_velocity", c.relaxation_velocity, {.low = 0.1, .high = 0.99},
             "OpenFOAM's relaxation factor of U; lower than for creeping flow, because inertia couples the equations");
    v.number("relaxation_pressure", c.relaxation_pressure, {.low = 0.01, .high = 0.99}, "OpenFOAM's relaxation factor of p");
    v.number("residual", c.residual, {.low = 1e-12, .high = 1e-2}, "OpenFOAM's residual of U and p at which a flow is steady");
    v.integer("max_iterations", c.max_iterations, record::between(2, 1000000),
              "a flow that is not steady after this number of iterations gets no result");
    v.integer("processes", c.processes, record::between(1, 256),
              "processes of OpenFOAM (mpirun), for the mesh and the flows; another number gives a slightly different mesh");
}

}  // namespace porepack::permeability
