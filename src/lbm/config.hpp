// Table [lbm] of case.toml.
#pragma once

#include "core/config.hpp"

namespace porepack {

struct LbmConfig {
    std::string direction = "z";
    std::string walls = "interpolated";
    std::string collision = "trt";
    std::string precision = "double";
    double relaxation_time = 1.2;
    double magic_number = 0.0;
    double tolerance = 1e-4;
    long max_steps = 200000;
    long grids = 2;
    double grid_ratio = 1.5;
    double superficial_velocity_m_per_s = 5e-5;
};

inline void describe(ConfigVisitor& v, LbmConfig& c) {
    v.choice("direction", c.direction, {"x", "y", "z"}, "direction of the flow; x and y in periodic boxes only");
    v.choice("walls", c.walls, {"interpolated", "bounce_back"},
             "interpolated: walls at their exact distance, second order; bounce_back: half-way between nodes, the paper's");
    v.choice("collision", c.collision, {"trt", "bgk"}, "two relaxation times, or one (the paper's; k then depends on relaxation_time)");
    v.choice("precision", c.precision, {"double", "single"}, "of the populations; single halves memory and time");
    v.number("relaxation_time", c.relaxation_time, {.low = 0.5, .high = 100.0, .low_open = true},
             "tau of the symmetric moments (lattice viscosity (tau - 1/2)/3); k does not depend on it, the number of steps does");
    v.number("magic_number", c.magic_number, {.low = 1e-6, .high = 10.0, .zero_is_auto = true},
             "Lambda = (tau+ - 1/2)(tau- - 1/2) of the two relaxation times; auto: 1/12 with interpolated walls, 3/16 with bounce_back");
    v.number("tolerance", c.tolerance, {.low = 1e-12, .high = 0.1}, "relative iteration error of k at which the run stops");
    v.integer("max_steps", c.max_steps, {.low = 1, .high = 1e9}, "give up after as many time steps");
    v.integer("grids", c.grids, between(1, 2), "1: one grid, no uncertainty; 2: a coarser grid first, their difference gives the interval");
    v.number("grid_ratio", c.grid_ratio, {.low = 1.1, .high = 4.0}, "voxel size of the coarser grid / voxel size");
    v.number("superficial_velocity_m_per_s", c.superficial_velocity_m_per_s, between(1e-12, 1e3),
             "physical state of flow.vti: water (1e-6 m2/s, 1000 kg/m3) at this superficial velocity");
}

}  // namespace porepack
