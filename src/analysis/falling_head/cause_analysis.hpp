// Causes of the difference between measured and computed permeabilities: each with its factor.
#pragma once

#include <optional>

#include "analysis/outcome.hpp"
#include "falling_head/config.hpp"
#include "pore_space/pore_space.hpp"
#include "results/falling_head.hpp"

namespace porepack::analysis {

/// k, k_in and what else is known of the flow.
struct FlowsOfSample {
    double permeability_m2, inertial_permeability_m, largest_reynolds;
    std::optional<double> quasi_steady_inertia;
};
/// Of a packing in a tube, with tables and figures. Throws UserError for another one, and where the bed is lower than the sample.
[[nodiscard]] Outcome<results::Causes> find_causes(const pore_space::PoreSpace& space, const FlowsOfSample& flows,
                                                   const falling_head::FallingHeadConfig& config);

}  // namespace porepack::analysis
