// Menisci: the grains of a pore space closed with a ball.
#pragma once

#include <array>
#include <vector>

#include "pore_space/pore_space.hpp"

namespace porepack::pore_space {

/// The same pore space, in which what no ball of this radius reaches between the grains, and between them and the container's sides, is
/// solid: their closing, as by menisci of a binder that wets them. Floor and planes form no meniscus. The grains stay exact; the menisci
/// are known on an image of signed distances, with voxels of closing_voxel_m() and an error of second order in them, for the whole bed.
/// Throws UserError where the pore space has no grains, or the image would have more than 1e9 voxels.
[[nodiscard]] PoreSpace closed(const PoreSpace& space, double radius_m);

/// A quarter of the radius, or a tenth of the grains' thickness where that is less.
[[nodiscard]] double closing_voxel_m(const PoreSpace& space, double radius_m);

/// Memory that making the image takes.
[[nodiscard]] double closing_memory_bytes(const PoreSpace& space, double radius_m);

/// Values of the signed distance from the closed solid at the centres of these cells, row by row: positive in pores. Distances beyond three
/// cells are cut. The cells are about cubes; periodic directions are periods of the grid.
[[nodiscard]] std::vector<float> closed_distances(const packing::Grains& grains, const geometry::Grid& grid, double radius_m,
                                                  const std::array<bool, 3>& periodic);

}  // namespace porepack::pore_space
