// Images of any size and type, read layer by layer.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <map>
#include "core/files.hpp"
#include "imaging/config.hpp"

namespace porepack::imaging {

/// Of an image whose axes are x, y, z in this order, x fastest, each in the direction of the axis.
struct VolumeHeader {
    std::array<std::int64_t, 3> voxels = {0, 0, 0};
    std::array<double, 3> spacing_m = {0, 0, 0};
    std::array<double, 3> origin_m = {0, 0, 0};  ///< lowest corner of the first voxel
    ValueType type = ValueType::uint8;
    std::string format;                        ///< "NRRD"
    std::string orientation;                   ///< how the file's axes became x, y, z
    std::string size_source;                   ///< where the voxel size comes from
    std::vector<core::Path> files;             ///< that are read
    bool own_phases = false;                   ///< a .vti file that PorePack wrote: `phase`, with a container
    bool own_fractions = false;                ///< the same with `solid_fraction`
    std::map<std::string, std::string> notes;  ///< field data of a .vti

    [[nodiscard]] std::int64_t layer() const { return voxels[0] * voxels[1]; }
    [[nodiscard]] std::int64_t count() const { return layer() * voxels[2]; }
};

/// An open image. Values are given in single precision, which holds all whole numbers up to 16,777,216 (larger ones are refused).
struct VolumeSource {
    VolumeHeader header;
    /// Layers first, first + 1, ... of z into `values`, whose size is a whole number of layers. Fastest in ascending order. Throws
    /// UserError where the file ends early or holds a value that is not finite, with its place.
    std::function<void(std::int64_t first, std::span<float> values)> read;
    double memory_bytes = 0.0;  ///< that it holds: 0 where the file is read layer by layer
};

/// Opens an image of any format of docs/images.md: the file (raw, .mhd, .mha, .nrrd, .nhdr, .tif, .npy, .vti), or a folder with one file
/// per layer (.tif, .png, .dcm) in the order of their names (DICOM: of their positions). Throws UserError for what is not understood, for
/// a file that is too short or too long, and for a voxel size that is missing or contradicts the file.
[[nodiscard]] VolumeSource open_volume(const core::Path& path, const ImageConfig& config = {});

/// A file or folder that open_volume() reads, by its name.
[[nodiscard]] bool is_volume(const core::Path& path);

/// Bytes of a value.
[[nodiscard]] std::size_t size_of(ValueType type);

/// Statistics by one pass: extremes, mean, and the number of voxels of each value, as long as there are at most 256.
struct VolumeStatistics {
    double minimum = 0.0, maximum = 0.0, mean = 0.0, deviation = 0.0;
    std::optional<std::map<double, std::int64_t>> values;
};
[[nodiscard]] VolumeStatistics statistics_of(const VolumeSource& source);

}  // namespace porepack::imaging
