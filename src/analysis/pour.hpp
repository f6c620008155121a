// Grains in a container: poured, or given.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/expectation.hpp"
#include "core/files.hpp"
#include "core/table.hpp"
#include "packing/packing.hpp"
#include "pouring/pour.hpp"
#include "results/pack.hpp"

namespace porepack::analysis {

struct Poured {
    results::Pack result;  ///< without its grains and its bed
    packing::Packing packing;
    std::optional<core::Table> protocol;  ///< protocol.csv, where there are steps
};
/// By the engine of `config`, not `none`. What an interrupted pour resumes from, and LIGGGHTS's run, lie in `folder`.
[[nodiscard]] Poured pour(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                          const pouring::PackingConfig& config, const pouring::ProtocolConfig& protocol, const core::Path& folder);
[[nodiscard]] core::Expectation expect_pour(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                                            const pouring::PackingConfig& config, const pouring::ProtocolConfig& protocol);

/// Numbers of the grains, their contacts and overlaps.
void add_grains(results::Pack& pack, const packing::Packing& packing);
/// A given packing must be the one that `shapes` and `container` describe; `file` for the messages of UserError.
void require_same_bed(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container, const packing::Packing& packing,
                      const std::string& file);

}  // namespace porepack::analysis
