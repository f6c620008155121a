// Vessels of kind "mesh", read from their files.
#pragma once

#include <vector>

#include "core/files.hpp"
#include "vessels/config.hpp"

namespace porepack::inputs {

/// The vessel of a case, whose files lie relative to `folder`. Throws UserError where make_container() does, or the file is no closed
/// surface of the inner space; it is moved along z to begin at 0.
[[nodiscard]] vessels::Container make_container(const vessels::ContainerConfig& config, const core::Path& folder);

/// The file that the vessel is read from, if any.
[[nodiscard]] std::vector<core::Path> vessel_files(const vessels::ContainerConfig& config, const core::Path& folder);

}  // namespace porepack::inputs
