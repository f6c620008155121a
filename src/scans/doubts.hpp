// What a segmented image shows that its user may not have meant.
#pragma once

#include <string>
#include <vector>

#include "geometry/grid.hpp"

namespace porepack::scans {

/// Sentences for warnings: layers at the sides that are pores only; a round sample in a square image, whose corners count as pores; pores
/// of one or two voxels. Empty where nothing is suspicious.
[[nodiscard]] std::vector<std::string> doubts_of(const geometry::PhaseImage& image);

}  // namespace porepack::scans
