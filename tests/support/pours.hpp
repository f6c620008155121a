// Pours of tests: the paper's grains alone, and what each bed has to fulfil.
#pragma once

#include <vector>

#include "packing/packing.hpp"
#include "pouring/pour.hpp"
#include "shapes/config.hpp"
#include "shapes/shape.hpp"
#include "support/helpers.hpp"

namespace porepack::test {

inline std::vector<ShapeShare> one(const Shape& shape) {
    return {{.shape = shape, .number_fraction = 1.0}};
}
inline Shape paper_shape(ShapeKind kind, double sphericity) {
    const Dimensions size = dimensions_for(kind, sphericity, 7.33e-7, Cavity::filled);
    return make_preset(kind, size.diameter_m, size.length_m);
}
inline void expect_sound(const PourResult& result, double largest_overlap = 0.02) {
    const Overlaps overlaps = find_overlaps(result.packing);
    EXPECT_LT(overlaps.largest_between_grains_m, largest_overlap * finest_diameter(result.packing));
    EXPECT_LT(result.kinetic_energy_per_grain_J, result.rest_limit_J);
    EXPECT_LT(*result.mean_force_over_weight, 0.05);
}

}  // namespace porepack::test
