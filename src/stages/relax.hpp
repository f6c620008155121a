// A given packing brought to rest: overlaps vanish, contacts appear.
#pragma once

#include "core/files.hpp"
#include "pouring/config.hpp"
#include "results/relax.hpp"

namespace porepack::stages {

/// Writes packing.json and movements.csv into `folder`. Throws UserError for keys of a pour, which have no effect here, and as relax().
[[nodiscard]] results::Relax relax_packing(const core::Path& file, const pouring::PackingConfig& config, const core::Path& folder);

}  // namespace porepack::stages
