// Closest points of two axes, and where two capsules press on each other.
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

/// To rounding, whatever the segments: parallel, crossing, of no length (after Lumelsky 1985, Ericson 2005).
[[nodiscard]] ClosestPoints closest_points(const Segment& p, const Segment& q);

/// Where on the first axis two overlapping capsules press, given their closest points: there, or for axes within 6 degrees of
/// parallel, in the middle of the stretch along which they overlap. That is the middle of the shared stretch when they are parallel
/// (the paper, 2.1.2), and it moves smoothly with the angle where the closest point would jump from end to end.
[[nodiscard]] Vec3 pressed_point(const Segment& p, const Segment& q, const ClosestPoints& closest, double overlap);

}  // namespace porepack::shapes
