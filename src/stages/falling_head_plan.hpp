// Which falling-head test tells k: a table of simulated tests.
#pragma once

#include "core/config.hpp"
#include "core/files.hpp"
#include "falling_head/plan.hpp"
#include "results/falling_head_tests.hpp"

namespace porepack::stages {

/// Writes plan.csv; the first test, from the cheapest on, whose interval of k is narrow enough.
[[nodiscard]] results::FallingHeadPlan plan_falling_head(double permeability_m2, double inertial_permeability_m,
                                                         const falling_head::FallingHeadConfig& apparatus,
                                                         const falling_head::TestPlanConfig& config, const core::Path& folder);

}  // namespace porepack::stages
