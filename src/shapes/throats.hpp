// Narrow passages between parts of the void; only for the sources of this folder.
#pragma once

#include <optional>

#include "shapes/void_grid.hpp"

namespace porepack::shapes {

/// Another part that root `part` is joined to: by the path to ever wider places, or by a throat, which is looked for along
/// the widest paths through cells that may hide one. None when no throat is found.
[[nodiscard]] std::optional<std::size_t> joined_part(VoidGrid& grid, std::size_t part);

}  // namespace porepack::shapes
