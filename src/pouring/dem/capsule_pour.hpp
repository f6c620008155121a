// Packing by the built-in DEM of exact shapes.
#pragma once

#include <vector>

#include "core/files.hpp"
#include "pouring/dem/capsule_dem.hpp"
#include "pouring/pour.hpp"

namespace porepack::pouring::dem {

[[nodiscard]] ContactLaw contact_law(const PackingConfig& config);

/// Uses the same batches as LIGGGHTS. Resumes from `folder`/snapshot.bin of an interrupted run with the same settings, and
/// removes it at the end. The steps of `protocol` follow when the poured bed is at rest; after them it comes to rest again. Throws
/// NumericalError when grains are lost, energy grows, or the grains do not come to rest.
[[nodiscard]] PourResult pour_with_capsules(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                                            const PackingConfig& config, const core::Path& folder, const ProtocolConfig& protocol = {});

}  // namespace porepack::pouring::dem
