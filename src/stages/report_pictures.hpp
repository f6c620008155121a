// What the report of a case shows of its bed.
#pragma once

#include <optional>

#include "core/files.hpp"
#include "report/bed_view.hpp"
#include "results/results.hpp"
#include "stages/case.hpp"

namespace porepack::stages {

/// packing.png in `folder`. False when rendering failed.
[[nodiscard]] bool draw_packing(const Case& c, const results::CaseResults& results, const core::Path& folder);
/// The bed to be turned, with streamlines. Nothing, with a warning, where it cannot be made: a report without it is a report still.
[[nodiscard]] std::optional<report::BedView> bed_to_turn(const Case& c, const results::CaseResults& results);

}  // namespace porepack::stages
