// Table [tortuosity] of case.toml.
#pragma once

#include "core/config.hpp"

namespace porepack {

struct TortuosityConfig {
    double dot_spacing_m = 0.005;
    double slice_spacing_m = 2e-4;
    double largest_angle_deg = 45.0;
};

inline void describe(ConfigVisitor& v, TortuosityConfig& c) {
    v.number("dot_spacing_m", c.dot_spacing_m, length(), "spacing of the paper's grid of dots");
    v.number("slice_spacing_m", c.slice_spacing_m, length(), "distance of the slices on which a path's points lie");
    v.number("largest_angle_deg", c.largest_angle_deg, {.low = 0.0, .high = 180.0, .low_open = true},
             "a moved dot is rejected when its direction turns by more between two slices");
}

}  // namespace porepack
