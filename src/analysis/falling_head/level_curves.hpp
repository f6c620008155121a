// Measured falling-head curves evaluated as in the paper and by least squares.
#pragma once

#include <vector>

#include "analysis/outcome.hpp"
#include "falling_head/config.hpp"
#include "falling_head/level_curve.hpp"
#include "results/falling_head_evaluation.hpp"

namespace porepack::analysis {

/// With the table analysis.csv (levels measured and fitted) and its figure. Throws as analyse_curves().
[[nodiscard]] Outcome<results::FallingHeadAnalysis> analyse_level_curves(const std::vector<falling_head::LevelCurve>& curves,
                                                                         const falling_head::FallingHeadConfig& config);

}  // namespace porepack::analysis
