// Which falling-head test tells k: a table of simulated tests.
#pragma once

#include "analysis/outcome.hpp"
#include "falling_head/plan.hpp"
#include "results/falling_head_evaluation.hpp"

namespace porepack::analysis {

/// With the table plan.csv; the first test, from the cheapest on, whose interval of k is narrow enough.
[[nodiscard]] Outcome<results::FallingHeadPlan> plan_falling_head(double permeability_m2, double inertial_permeability_m,
                                                                  const falling_head::FallingHeadConfig& apparatus,
                                                                  const falling_head::TestPlanConfig& config);

}  // namespace porepack::analysis
