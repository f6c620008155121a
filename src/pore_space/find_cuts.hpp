// Which links between pore cells solid closes (link_cuts.hpp).
#pragma once

#include "pore_space/link_cuts.hpp"
#include "pore_space/walls.hpp"

namespace porepack::pore_space {

/// Of a slab: the closed links of the cells without the halo, whose phases are needed.
/// By exact hits. The solid must be that of the image; through an open end of the grid its mirror image follows (see WallFinder).
[[nodiscard]] LinkCuts find_cuts(const geometry::PhaseImage& image, const FlowWalls& walls, const Drive& drive);
/// Of an image: the links across an edge whose other two voxels are both solid.
[[nodiscard]] LinkCuts find_cuts(const geometry::PhaseImage& image, const Drive& drive);

}  // namespace porepack::pore_space
