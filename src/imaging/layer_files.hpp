// The files of a folder that are the layers of one image.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::imaging {

/// ".tif" of "a.TIF".
[[nodiscard]] std::string lower_extension(const core::Path& path);

/// Files of the folder with one of the endings, slice_2 before slice_10; hidden ones are left out. Throws UserError where such a name is no
/// regular file.
[[nodiscard]] std::vector<core::Path> layers_in(const core::Path& folder, std::initializer_list<const char*> extensions);

/// Throws UserError unless the names differ in numbers only, and one of these grows by equal steps: else a file is no layer, or a layer is
/// missing.
void require_numbered(const std::vector<core::Path>& layers);

}  // namespace porepack::imaging
