// Images written layer by layer, and cut or binned on the way.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/files.hpp"
#include "geometry/grid.hpp"
#include "imaging/volume.hpp"

namespace porepack::imaging {

/// A part of an image; voxels from low to high, high excluded.
struct Box {
    std::array<std::int64_t, 3> low = {0, 0, 0}, high = {0, 0, 0};
};

/// The part of `source` in the box. Throws UserError for a box that is not in the image.
[[nodiscard]] VolumeSource cropped(VolumeSource source, const Box& box);
/// Means of factor x factor x factor voxels, in single precision; what is left over at the far sides is dropped. Throws UserError for a
/// factor below 2 or above a side.
[[nodiscard]] VolumeSource binned(VolumeSource source, std::int64_t factor);

/// Values on a grid as an image, float32. They must outlive it.
[[nodiscard]] VolumeSource source_of(const geometry::Grid& grid, const std::vector<float>& values);

/// Writes .raw, .mhd (with a .raw beside it), .nrrd, .npy (C order, shape z, y, x) or .vti (cell data `value`) by the name's ending. The
/// values keep their type; those of a binned image are float32. Memory: a few layers.
void write_volume(const core::Path& path, const VolumeSource& source);

}  // namespace porepack::imaging
