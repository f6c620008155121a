// Table [openfoam] of case.toml.
#pragma once

#include "record/config.hpp"

namespace porepack::openfoam {

/// Meaning, unit, range and default of each key: see describe(). 0 means "chosen automatically" where that is allowed.
struct FoamConfig {
    bool enabled = true;
    double cell_size_m = 0.0;
    long meshes = 2;
    double mesh_ratio = 1.5;
    long surface_level = 1;
    double relaxation_velocity = 0.95;
    double relaxation_pressure = 0.15;
    double residual = 1e-6;
    long max_iterations = 1000;
    long processes = 1;
};

inline void describe(record::ConfigVisitor& v, FoamConfig& c) {
    v.boolean("enabled", c.enabled, "run the OpenFOAM cross-check");
    v.number("cell_size_m", c.cell_size_m, record::length_range_or_auto(),
             "size of the background cells of the finest mesh; auto: the smallest thickness of the grains / 4");
    v.integer("meshes", c.meshes, record::between(1, 3),
              "1: one mesh, and no uncertainty is given; 2: also a coarser mesh, and k is extrapolated; 3: three meshes, and the observed "
              "order and the grid convergence index are computed");
    v.number("mesh_ratio", c.mesh_ratio, {.low = 1.2, .high = 3.0},
             "size of the background cells of a mesh / size of those of the next finer mesh");
    v.integer("surface_level", c.surface_level, record::between(0, 3),
              "cells at grains and wall are 2^level times finer; 2 where gaps are narrower than two cells");
    v.number("relaxation_velocity", c.relaxation_velocity, {.low = 0.1, .high = 0.99},
             "relaxation factor of the velocity U; lower it when the run diverges");
    v.number("relaxation_pressure", c.relaxation_pressure, {.low = 0.01, .high = 0.99},
             "relaxation factor of the pressure p; 3 (1 - relaxation_velocity) is best, much larger values diverge");
    v.number("residual", c.residual, {.low = 1e-12, .high = 1e-2},
             "residual of U and p at which the solver stops; the relative error of the flux is then about the same");
    v.integer("max_iterations", c.max_iterations, record::between(2, 1000000),
              "a run that has not converged after this number of iterations is an error");
    v.integer("processes", c.processes, record::between(1, 256),
              "processes (mpirun) that mesh and solve the finest mesh, each number with a slightly different mesh; the coarser meshes are "
              "computed "
              "at the same time, on one process");
}

}  // namespace porepack::openfoam
