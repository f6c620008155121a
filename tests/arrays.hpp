// Solving what is known.
#pragma once

#include "helpers.hpp"
#include "lbm/known.hpp"

namespace porepack::test {

inline LbmResult solve(const KnownFlow& known, double cells_per_unit, LbmConfig config, bool with_flow = false) {
    config.direction = config.direction == Axis::z ? known.direction : config.direction;
    return lbm_permeability(known.pore_space(), 1.0 / cells_per_unit, config, {.with_flow = with_flow});
}

inline double error_of(const KnownFlow& known, double cells_per_unit, const LbmConfig& config) {
    return solve(known, cells_per_unit, config).fine().permeability_m2 / known.permeability_m2 - 1.0;
}

}  // namespace porepack::test
