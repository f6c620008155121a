// Where a line passes through a torus.
#pragma once

#include <vector>

#include "core/interval.hpp"
#include "geometry/vector.hpp"

namespace porepack::shapes {

/// Appends the parts (at most two) of the line origin + t direction (unit vector) within `tube_radius` of the circle of `circle_radius`
/// about the axis z at height 0.
void add_torus_parts(double circle_radius, double tube_radius, const geometry::Vec3& origin, const geometry::Vec3& direction,
                     std::vector<core::Interval>& parts);

}  // namespace porepack::shapes
