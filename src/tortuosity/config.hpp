// Table [tortuosity] of case.toml.
#pragma once

#include "core/choice.hpp"
#include "record/config.hpp"

namespace porepack::tortuosity {

/// Meaning, unit, range and default of each key: see describe().
struct TortuosityConfig {
    double dot_spacing_m = 0.005;
    double slice_spacing_m = 2e-4;
    double largest_angle_deg = 45.0;
    double dot_pixel_m = 0.0;
    double dot_radius_m = 0.0;
    core::Axis direction = core::Axis::z;
    bool shortest_path = true;
    bool diffusive = true;
};

inline void describe(record::ConfigVisitor& v, TortuosityConfig& c) {
    v.number("dot_spacing_m", c.dot_spacing_m, record::length_range(),
             "spacing of the grid of dots, from which the paths of geometric_paper are made (section 2.1.3 of the paper); an eighth of "
             "the width in a container less than three of them wide");
    v.number("slice_spacing_m", c.slice_spacing_m, record::length_range(), "distance between the slices on which the points of a path lie");
    v.number("largest_angle_deg", c.largest_angle_deg, {.low = 0.0, .high = 180.0, .low_open = true},
             "a moved dot is rejected if the direction of its path changes by more than this angle between two slices");
    v.number("dot_pixel_m", c.dot_pixel_m, {.low = 0.0, .high = 1.0},
             "moved dots are placed at the centres of pixels of this size, as on slice images; 0: at their exact position");
    v.number("dot_radius_m", c.dot_radius_m, record::positive_or_auto(),
             "only dots within this distance from the axis of the cylinder are used (the paper: 0.04); auto: all dots");
    v.choice("direction", c.direction, "direction of shortest_path and diffusive; x and y are possible for periodic boxes and images");
    v.boolean("shortest_path", c.shortest_path, "in a case: compute shortest paths as well");
    v.boolean("diffusive", c.diffusive, "in a case: compute the tortuosity factor eps D0/D_eff as well, by diffusion on three grids");
}

}  // namespace porepack::tortuosity
