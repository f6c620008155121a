// Grains with their fitted poses and sizes as an image would show them.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/grid.hpp"
#include "scans/refine.hpp"

namespace porepack::scans {

/// Solid fraction at a blurred edge, `x` standard deviations of the blur inside of it.
[[nodiscard]] double inside_of_edge(double x);

/// The shape with fitted radii and lengths.
[[nodiscard]] std::vector<shapes::Capsule> resized(const std::vector<shapes::Capsule>& capsules, double radius_change_m,
                                                   double length_factor);

/// Solid fractions of the fitted grains, as an image of this blur would show them: 0 to 255.
[[nodiscard]] std::vector<std::uint8_t> rendered(const geometry::Grid& grid, const std::vector<ShapePoints>& shapes, const Refined& found,
                                                 double blur_m);

}  // namespace porepack::scans
