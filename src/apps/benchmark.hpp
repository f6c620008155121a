// Measurements: they report, they do not judge.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack {

[[nodiscard]] const std::vector<std::string>& benchmark_names();
/// Whether intervals cover, for LbmConfig::tolerance; a row for each tolerance and each flow.
[[nodiscard]] Json coverage_benchmark(const std::vector<unsigned>& seeds, const std::vector<double>& tolerances);
/// Speed of the kernels against the memory's limit, steps of the schemes to the same gate, error against seconds.
[[nodiscard]] Json lbm_benchmark(const Path& folder);
/// Runs both flow solvers of the cases as far as that is not done, and compares k, cost and mean profiles of the speed.
[[nodiscard]] Json cross_check_benchmark(const std::vector<Path>& cases, const Path& folder);
/// Writes <name>.json and plots into `folder` unless it is empty. Throws UserError for a name that is not known.
[[nodiscard]] Json run_benchmark(const std::string& name, const std::vector<Path>& cases, const Path& folder);

}  // namespace porepack
