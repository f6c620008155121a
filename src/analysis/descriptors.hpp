// Dimensionless numbers of the bed, its friction factor beside correlations, its structure, and the part of the wall.
#pragma once

#include <optional>

#include "analysis/outcome.hpp"
#include "geometry/grid.hpp"
#include "pore_space/pore_space.hpp"
#include "results/descriptors.hpp"
#include "results/forchheimer.hpp"
#include "results/lbm.hpp"

namespace porepack::analysis {

/// `flow`: the flow field, for the part of the wall of a cylinder; may be null. Friction factors need `forchheimer`.
[[nodiscard]] Outcome<results::Descriptors> describe_bed(const pore_space::PoreSpace& space, const results::Lbm& lbm,
                                                         const geometry::FlowImage* flow,
                                                         const std::optional<results::Forchheimer>& forchheimer);

}  // namespace porepack::analysis
