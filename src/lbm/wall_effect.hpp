// Effect of the container wall on the permeability of a packing in a tube.
#pragma once

#include "converters/pore_space.hpp"

namespace porepack::lbm {

/// k of the core, `layer_m` from the wall, over k of the whole tube: mean velocities of one coarse flow (6 nodes per capsule diameter) over
/// the section of `space`, whose container is a cylinder.
[[nodiscard]] double core_over_tube_permeability(const converters::PoreSpace& space, double layer_m);

}  // namespace porepack::lbm
