// Two samples in one apparatus: do the causes that both tests have in common give both factors at once?
#pragma once

#include <vector>

#include "analysis/outcome.hpp"
#include "core/files.hpp"
#include "results/falling_head_evaluation.hpp"

namespace porepack::analysis {

/// `samples`: two results of the stage causes (folders of cases, or result.json). `factors`: to be explained, of both samples; empty: those
/// of the results. With common_causes.csv (each draw) and common_causes.svg. Throws UserError for a result without a sample, and for two
/// that were not tested in one apparatus.
[[nodiscard]] Outcome<results::CommonCauses> compare_causes(const std::vector<core::Path>& samples, const std::vector<double>& factors);

/// The results that compare_causes() reads: for the manifest.
[[nodiscard]] std::vector<core::Path> results_of_causes(const std::vector<core::Path>& samples);

}  // namespace porepack::analysis
