// Walls of a segmented image, smoother than its voxels.
#pragma once

#include <array>

#include "geometry/grid.hpp"
#include "scans/gray_input.hpp"

namespace porepack::scans {

/// The solid is the union of the largest balls that fit between its pores: about each of its voxels a ball reaches to half a voxel before
/// the nearest pore's centre. A union keeps the creases in which grains touch, which smoothing would fill; and no pore's centre lies in a
/// ball, so the topology is that of the voxels. What the lattice leaves of roughness is smoothed, by a tenth of a voxel at most, and the
/// level keeps the volume of the voxels. `image` lies in the container's frame.
///
/// The walls' places count as known to wall_error_voxels (standard uncertainty), judged on voxelised arrays and packings
/// (docs/images.md).
[[nodiscard]] GrayInput walls_of_balls(const geometry::PhaseImage& image, const vessels::Container& container);
inline constexpr double wall_error_voxels = 0.015;

/// The solid was made by walls_of_balls().
[[nodiscard]] bool has_walls_of_balls(const pore_space::GraySolid& solid);

/// Memory while they are made, per voxel of the image.
inline constexpr double bytes_per_voxel_of_balls = 8.0;

/// Part of the solid's voxels, and of the pores', that lie in features of one or two voxels, and more than two voxels from wider
/// ones.
struct ThinParts {
    double solid = 0.0, pores = 0.0;
};
[[nodiscard]] ThinParts thin_parts(const geometry::PhaseImage& image, const std::array<bool, 3>& periodic);

}  // namespace porepack::scans
