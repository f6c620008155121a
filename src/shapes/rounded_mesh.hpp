// Grains of triangles with rounded edges that need not be convex.
#pragma once

#include <memory>

#include "shapes/rounded_body.hpp"
#include "shapes/triangle_core.hpp"

namespace porepack::shapes {

/// The core with a ball of radius `rounding_m` swept over it. Its facets are not given: grain_mesh() finds them from the distance.
[[nodiscard]] std::shared_ptr<const RoundedBody> make_rounded_mesh(std::shared_ptr<const TriangleCore> core, double rounding_m);

}  // namespace porepack::shapes
