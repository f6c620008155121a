// Grains of a segmented scan as closed surfaces: a library of stones from which new beds are poured.
#pragma once

#include <cstdint>
#include <vector>

#include "core/files.hpp"
#include "core/table.hpp"
#include "geometry/gray_image.hpp"
#include "io/stl.hpp"

namespace porepack::analysis {

/// Surfaces have at most so many triangles: about 0.2 % of the diameter between a stone and its surface.
inline constexpr long library_faces = 2000;

struct StoneLibrary {
    std::vector<std::uint32_t> labels = {};                ///< of the stones, ascending
    std::vector<geometry::TriangleSurface> surfaces = {};  ///< in metres, where the stone lies in the scan
    long left_out = 0;                                     ///< their surface is not closed, or crosses itself
};

/// Each of these grains where the gray values cross the level. `owner`: by voxel, the grain whose solid or blurred edge it is; where two
/// grains touch, both end halfway between their voxels.
[[nodiscard]] StoneLibrary stones_of(const geometry::GrayImage& gray, const std::vector<std::uint32_t>& owner,
                                     const std::vector<std::uint32_t>& labels);

/// stone_00001.stl, ... and stones.csv with the measures of each.
void write_library(const StoneLibrary& library, const core::Path& folder);

}  // namespace porepack::analysis
