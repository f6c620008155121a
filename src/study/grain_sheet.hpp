// Grains side by side, for a picture.
#pragma once

#include <vector>

#include "io/stl.hpp"
#include "shapes/shape.hpp"

namespace porepack::study {

/// One surface in metres, in rows of `columns` grains from the bottom up; each grain is turned alike, `pitch_m` from the next.
[[nodiscard]] geometry::TriangleSurface grain_sheet(const std::vector<shapes::Shape>& grains, long columns, double pitch_m);

}  // namespace porepack::study
