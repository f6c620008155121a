// Grains of a segmented image: cavities filled, touching grains separated by a watershed (Beucher & Lantuejoul 1979; Meyer 1994).
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/grid.hpp"

namespace porepack::imaging {

/// Makes pores that no path connects to the sides of the image solid; returns their number of voxels. Paths lead over faces.
std::int64_t fill_cavities(const geometry::Grid& grid, std::vector<std::uint8_t>& solid);

struct Separated {
    std::vector<std::uint32_t> label;  ///< of each voxel; 0 pores
    std::uint32_t count = 0;           ///< labels are 1 .. count
};
/// Watershed on the distance to the surface, from its maxima that stand out by `height_m` or more: too low, and grains are split along
/// arms of equal thickness; too high, and touching grains stay merged. About 33 bytes per voxel. Throws MachineError without memory.
[[nodiscard]] Separated separate_grains(const geometry::Grid& grid, const std::vector<std::uint8_t>& solid, double height_m);

}  // namespace porepack::imaging
