// Closest points of two axes, and the contact point of two capsules.
#pragma once

#include "shapes/capsule.hpp"

namespace porepack::shapes {

/// An axis: from `start` along `along`, which may be zero (a sphere).
struct Segment {
    Vec3 start, along;
};

struct ClosestPoints {
    Vec3 on_first, on_second;
    double distance;
};

/// Exact to rounding for all segments: parallel, crossing, of zero length (after Lumelsky 1985, Ericson 2005).
[[nodiscard]] ClosestPoints closest_points(const Segment& p, const Segment& q);

/// Contact point of two overlapping capsules on the first axis, given their closest points: there, or for axes within 6 degrees of
/// parallel, in the middle of the interval along which they overlap. That is the middle of the shared interval when they are parallel
/// (the paper, 2.1.2), and it moves smoothly with the angle, whereas the closest point would jump from end to end.
[[nodiscard]] Vec3 pressed_point(const Segment& p, const Segment& q, const ClosestPoints& closest, double overlap);

}  // namespace porepack::shapes
