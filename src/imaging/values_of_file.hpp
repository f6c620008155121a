// The values of a file that follow each other without structure.
#pragma once

#include <cstdint>

#include "core/files.hpp"
#include "imaging/file_axes.hpp"

namespace porepack::imaging {

/// Where the values lie in a file, x fastest.
struct ValuesOfFile {
    core::Path path;
    std::uint64_t start = 0;  ///< byte of the file at which they begin, or what holds them packed
    bool packed = false;      ///< by gzip or zlib
    std::uint64_t skip = 0;   ///< bytes before the first value, after unpacking
    bool big_endian = false;  ///< order of the bytes of a value
};

/// Sets `volume.read`, with the type and the voxels of `volume`. Surplus and missing bytes are UserErrors: here, or of packed files when
/// the last layer is read.
void read_values(FileVolume& volume, const ValuesOfFile& of);

}  // namespace porepack::imaging
