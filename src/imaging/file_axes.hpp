// What a file says, before its axes are put into the order x, y, z.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "imaging/volume.hpp"

namespace porepack::imaging {

/// A file's own axes, fastest first.
struct FileVolume {
    std::array<std::int64_t, 3> voxels = {0, 0, 0};
    ValueType type = ValueType::uint8;
    std::string format;
    std::optional<std::array<double, 3>> spacing;  ///< none: the file states none
    std::optional<double> unit_m;                  ///< of the spacing and origin; none: the file does not say
    std::array<double, 3> origin = {0, 0, 0};      ///< centre of the first voxel, along x, y, z; in the unit
    bool origin_is_corner = false;                 ///< it is the lowest corner instead
    /// Column i: direction of the file's axis i in x, y, z. Identity where the file states none.
    std::array<std::array<double, 3>, 3> direction = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    bool states_direction = false;
    bool own_phases = false, own_fractions = false;
    bool sequential = false;        ///< packed: reading backwards begins at the start each time
    std::vector<core::Path> files;  ///< that are read
    std::map<std::string, std::string> notes;
    /// Layers of the slowest axis, as in VolumeSource.
    std::function<void(std::int64_t first, std::span<float> values)> read;
    double memory_bytes = 0.0;
};

/// One function per format. Each checks sizes before it reads.
[[nodiscard]] FileVolume open_raw(const core::Path& path, const ImageConfig& config);
[[nodiscard]] FileVolume open_npy(const core::Path& path);
[[nodiscard]] FileVolume open_tiff(const std::vector<core::Path>& pages_or_file);
[[nodiscard]] FileVolume open_meta(const core::Path& path);
[[nodiscard]] FileVolume open_nrrd(const core::Path& path);
[[nodiscard]] FileVolume open_png_stack(const std::vector<core::Path>& files);
[[nodiscard]] FileVolume open_dicom(const core::Path& folder);
[[nodiscard]] FileVolume open_vti(const core::Path& path, const std::string& field);

/// Converts `count` values of the type from bytes in the machine's order. Throws UserError for values that single precision does not
/// hold.
void to_float(const void* bytes, ValueType type, std::span<float> values, const core::Path& file);
void swap_bytes(void* bytes, std::size_t size, std::size_t count);

}  // namespace porepack::imaging
