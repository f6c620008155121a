// Packing by our own DEM of exact capsules.
#pragma once

#include "packing/dem/capsule_dem.hpp"
#include "packing/pour.hpp"

namespace porepack::packing::dem {

[[nodiscard]] ContactLaw contact_law(const PackingConfig& config);

/// The same batches as LIGGGHTS gets. Resumes from `folder`/snapshot.bin when an interrupted run with the same settings left it, and
/// removes it at the end. Throws NumericalError when grains are lost, energy grows, or the grains do not come to rest.
[[nodiscard]] PourResult pour_with_capsules(const std::vector<shapes::ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                                            const core::Path& folder);

}  // namespace porepack::packing::dem
