// Arrays of .vti files of any producer, read layer by layer: point or cell data; ASCII, binary, appended, compressed; several pieces.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "core/files.hpp"

namespace porepack::io {

struct VtiVolume {
    std::array<std::int64_t, 3> values = {0, 0, 0};  ///< along the axes of the file, the fastest first
    bool at_points = false;
    std::array<double, 3> spacing = {0, 0, 0};
    bool has_spacing = true;                                                               ///< false: the file states none
    std::array<double, 3> origin = {0, 0, 0};                                              ///< centre of the first value
    std::array<std::array<double, 3>, 3> direction = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< of axis i
    std::string field, type;                                                               ///< "UInt8", as in the file
    std::size_t bytes = 0;                                                                 ///< of a value
    std::string storage;                                                                   ///< "appended, zlib"
    std::map<std::string, std::string> notes;                                              ///< texts of the field data
    /// Layers first, first + 1, ... in the machine's byte order.
    std::function<void(std::int64_t first, std::int64_t count, void* values)> read;
};

/// `field`: name of the array; empty: `phase`, or the only one. Throws UserError for what is not an image, for pieces that do not make up
/// the whole, and for an array with more or fewer values than the image has.
[[nodiscard]] VtiVolume open_vti_volume(const core::Path& path, const std::string& field);

}  // namespace porepack::io
