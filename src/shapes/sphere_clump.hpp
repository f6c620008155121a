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

/// All radii larger by one length, so that the union has this volume, to 1e-3. (Beds of spheres that all lie inside are too dense: of
/// their exact grains, which are larger.)
[[nodiscard]] std::vector<Capsule> with_volume(std::vector<Capsule> spheres, double volume_m3);

/// Largest distance from points of a body's surface, up to 20,000, to the nearest sphere's surface below or above them.
[[nodiscard]] double clump_error(const Shape& shape, const std::vector<Capsule>& spheres);

}  // namespace porepack::shapes
