// Solving what is known.
#pragma once

#include "lbm/known.hpp"

namespace porepack::test {

inline LbmResult solve(const KnownFlow& known, double cells_a_unit, LbmConfig config, bool with_flow = false) {
    config.direction = config.direction == "z" ? known.direction : config.direction;
    return lbm_permeability(known.scene(), 1.0 / cells_a_unit, config, with_flow);
}

inline double error_of(const KnownFlow& known, double cells_a_unit, const LbmConfig& config) {
    return solve(known, cells_a_unit, config).fine().permeability_m2 / known.permeability_m2 - 1.0;
}

}  // namespace porepack::test
