// A clump of spheres that stands for a grain, for engines that know only spheres.
#pragma once

#include <vector>

#include "shapes/shape.hpp"

namespace porepack::shapes {

/// Spheres inside the grain whose union lies within `tolerance` (m) below its surface; each is a capsule with a = b. Capsules get spheres
/// along their axes, 2 sqrt(r^2 - (r - tolerance)^2) apart. A grain with faces gets few of the largest spheres that touch its surface from
/// inside: always the one that covers the most of the surface that is not yet within the tolerance (greedy set cover).
/// Throws UserError unless the tolerance is positive and smaller than the radius of each capsule, or half the thickness of a body.
[[nodiscard]] std::vector<Capsule> sphere_clump(const Shape& shape, double tolerance);

struct SphereClump {
    std::vector<Capsule> spheres;
    double tolerance_m = 0.0;
};
/// The clump of at most so many spheres with the smallest tolerance, to 2 %. Throws UserError where none has so few.
[[nodiscard]] SphereClump clump_of_at_most(const Shape& shape, long spheres);

/// Largest distance from points of a body's surface, up to 20,000, down to the nearest sphere.
[[nodiscard]] double clump_error(const Shape& shape, const std::vector<Capsule>& spheres);

}  // namespace porepack::shapes
