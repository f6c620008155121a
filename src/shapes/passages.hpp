// Narrow passages between parts of the void; only for the sources of this folder.
#pragma once

#include <optional>

#include "shapes/void_grid.hpp"

namespace porepack::shapes {

/// Another part that root `part` is joined to: by the path to points of larger clearance, or by a throat, searched along
/// the widest paths through cells that may contain one. None when no throat is found.
[[nodiscard]] std::optional<std::size_t> joined_part(VoidGrid& grid, std::size_t part);

}  // namespace porepack::shapes
