// Files of a design: proposals.csv, design.json, design.html with its figures.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "design/design.hpp"

namespace porepack::design {

/// "tetrapod, sphericity 0.612, d_v 11.2 mm, capsules 4.1 mm thick".
[[nodiscard]] std::string description(const SizedCandidate& grain);

[[nodiscard]] double expected_permeability_m2(const SizedCandidate& grain);

/// The files that write_design() writes.
[[nodiscard]] const std::vector<std::string>& design_files();
/// `known`: the beds that the search began with and those that it has added.
void write_design(const DesignGoal& goal, const DesignResult& result, const std::vector<KnownBed>& known, const core::Path& folder);

}  // namespace porepack::design
