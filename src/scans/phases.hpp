// From the values of an image to pores and solid.
#pragma once

#include <string>

#include "geometry/grid.hpp"
#include "imaging/volume.hpp"

namespace porepack::scans {

struct SegmentedImage {
    geometry::PhaseImage image;  ///< origin and notes as in the file
    std::string pore_level;      ///< "values below 41.5": what was taken for pores
};

/// Pores by `pore`, by `threshold`, or, in a .vti file whose array is `phase`, by PorePack's own values (0 solid, 1 pore, 2 outside). Read
/// layer by layer: one byte per voxel is held. Throws UserError where none of them is given, where nothing or everything would be pore,
/// for voxels that are no cubes, and for more voxels than the solvers hold.
[[nodiscard]] SegmentedImage segmented(const imaging::VolumeSource& source, const imaging::ImageConfig& config, const std::string& where);

/// The grid of an image that is held in memory. Throws UserError for voxels that are no cubes, and for more voxels than the solvers or the
/// memory hold.
[[nodiscard]] geometry::Grid usable_grid(const imaging::VolumeHeader& header, const std::string& where, double bytes_per_voxel);

}  // namespace porepack::scans
