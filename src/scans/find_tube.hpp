// The inner circle of a tube along z.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scans/gray_levels.hpp"

namespace porepack::scans {

struct Tube {
    double x_voxels = 0.0, y_voxels = 0.0;  ///< of the axis, from the corner of the image
    double radius_voxels = 0.0;
    double residual_voxels = 0.0;  ///< root mean square of the edge's distances from the circle
};

/// From the mean of all layers, where a tube is a bright ring: the edge is where rays from outside leave it, at half its brightness; then
/// least squares, twice without edges that are off. Two passes over the image. Throws UserError where there is no such ring.
/// `explained`: the share of each voxel that grains fill (0 to 255), where that is known; they do not shift the edge then.
[[nodiscard]] Tube find_tube(const imaging::VolumeSource& source, imaging::PoreSide pores, const std::string& where,
                             const std::vector<std::uint8_t>& explained = {});

}  // namespace porepack::scans
