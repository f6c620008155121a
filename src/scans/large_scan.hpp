// A scan whose grains are fitted, of any size.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "imaging/volume.hpp"
#include "scans/gray_input.hpp"
#include "scans/refine.hpp"

namespace porepack::scans {

/// A scan that is larger than the memory is binned for the search, and its own voxels are read slab by slab after that.
struct Scan {
    imaging::VolumeSource source;
    std::int64_t bin = 1;       ///< side of the voxels that are held in memory, in voxels of the scan
    int search_bin = 1;         ///< side of the voxels of the search, in voxels that are held
    double memory_bytes = 0.0;  ///< that the fit may take

    [[nodiscard]] double voxel_size_m() const { return source.header.spacing_m[0]; }
    [[nodiscard]] imaging::VolumeSource reduced() const;
};

/// Throws UserError for grains whose thinnest part (diameter) is below 4 voxels, and MachineError where it would be after binning.
[[nodiscard]] Scan open_scan(const imaging::VolumeSource& source, const imaging::ImageConfig& image, double thinnest_m,
                             const std::string& where);

/// Poses at the scan's own resolution. `found`: from binned voxels; `reduced`, `notes`: of these. Throws MachineError where not even a slab
/// fits into memory.
[[nodiscard]] Refined refine_at_full_size(const Scan& scan, const geometry::GrayImage& reduced, const GrayNotes& notes,
                                          const vessels::Container& container, const std::vector<ShapePoints>& points, Refined found,
                                          const std::string& where);

}  // namespace porepack::scans
