// Packing by LIGGGHTS: writes a run that can be repeated by hand, runs it, reads the poses back and checks them.
#pragma once

#include <optional>
#include <vector>

#include "core/files.hpp"
#include "pouring/batches.hpp"
#include "pouring/pour.hpp"

namespace porepack::pouring::liggghts {

/// Runs in `folder`, which is created and contains all inputs and logs. `templates` is the folder liggghts_templates/. Grains come from
/// `given` if it is set, else from make_batches. The steps of `protocol` follow.
/// Throws EngineError when LIGGGHTS is missing, fails or loses a grain, NumericalError when the grains do not come to rest.
[[nodiscard]] PourResult pour_with_liggghts(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                                            const PackingConfig& config, const core::Path& templates, const core::Path& folder,
                                            const std::optional<Pour>& given = {}, const ProtocolConfig& protocol = {});

}  // namespace porepack::pouring::liggghts
