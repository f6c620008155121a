// A given packing brought to rest: overlaps vanish, contacts appear.
#pragma once

#include "analysis/outcome.hpp"
#include "packing/packing.hpp"
#include "pouring/config.hpp"
#include "results/relax.hpp"

namespace porepack::analysis {

struct Relaxation {
    Outcome<results::Relax> outcome;  ///< with movements.csv
    packing::Packing packing;
};
/// Throws UserError for keys of a pour, which have no effect here, and as relax().
[[nodiscard]] Relaxation relax_packing(const packing::Packing& given, const pouring::PackingConfig& config);
/// packing.json beside the table.
[[nodiscard]] results::Relax written(const Relaxation& relaxation, const core::Path& folder);

}  // namespace porepack::analysis
