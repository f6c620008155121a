// The surface of a gray image at its level, by VTK.
#pragma once

#include "geometry/gray_image.hpp"
#include "io/stl.hpp"

namespace porepack::io {

/// Closed: beyond the sides of the image there is no solid.
[[nodiscard]] TriangleSurface iso_surface(const geometry::GrayImage& image);

}  // namespace porepack::io
