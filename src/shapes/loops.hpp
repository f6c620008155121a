// Closed surfaces from loops of points about the axis z: what cylinders, rings and grains with lobes have in common.
#pragma once

#include <vector>

#include "shapes/rounded_body.hpp"

namespace porepack::shapes {

/// An arc is divided into equal parts, two or more, so that the polygon has the area of the sector: its ends lie on the arc, the corners
/// between them farther out by a factor.
struct DividedArc {
    int parts;
    double factor;
};
[[nodiscard]] double arc_factor(double angle, int parts);
/// The coarsest one whose corners lie within `deviation`; `angle` (rad) below pi.
[[nodiscard]] DividedArc divided_arc(double radius, double angle, double deviation);
/// A circle, likewise; at least eight parts.
[[nodiscard]] DividedArc divided_circle(double radius, double deviation);

/// Loops with the same number of points, counter-clockwise seen from above.
using Loop = std::vector<Vec3>;
/// Facets from each loop to the next, outside on the right of that way seen in a half-plane (distance from the axis, z). `closed`: from the
/// last to the first too; otherwise the first and the last are closed by facets to a point of the axis. Facets without area are left out.
[[nodiscard]] std::vector<Facet> facets_between(const std::vector<Loop>& loops, bool closed);

}  // namespace porepack::shapes
