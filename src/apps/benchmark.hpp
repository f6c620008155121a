// Measurements: they report, they do not judge.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "openfoam/foam.hpp"

namespace porepack {

[[nodiscard]] const std::vector<std::string>& benchmark_names();
/// Whether intervals cover, for LbmConfig::tolerance; a row for each tolerance and each flow.
[[nodiscard]] Json coverage_benchmark(const std::vector<unsigned>& seeds, const std::vector<double>& tolerances);
/// Speed of the kernels against the memory's limit, steps of the schemes to the same gate, error against seconds.
[[nodiscard]] Json lbm_benchmark(const Path& folder);
/// Runs both flow solvers of the cases as far as that is not done, and compares k, cost and mean profiles of the speed.
[[nodiscard]] Json cross_check_benchmark(const std::vector<Path>& cases, const Path& folder);
/// OpenFOAM on flows of known answer; its cases lie in `folder` (or ./foam_verification).
[[nodiscard]] Json foam_benchmark(const Path& folder);
/// A packing as OpenFOAM takes it; `deviation` of its surface over the grain's size.
[[nodiscard]] FoamScene foam_scene(const Packing& packing, const Section& section, double grain_size_m, double deviation = 0.003);
/// Both packing engines: porosity of several packings, seconds against the clumps' surface tolerance; writes packing_engines.svg into
/// `folder`.
[[nodiscard]] Json packing_benchmark(bool quick, const Path& folder);
/// The paper's tortuosity against all it depends on, error against seconds of the others; writes tortuosity_study.svg into `folder`.
[[nodiscard]] Json tortuosity_benchmark(bool quick, const Path& folder);
/// Error against cost of both solvers and the paper's scheme; writes speed_error.svg and .csv into `folder` (or ./speed_error).
[[nodiscard]] Json speed_error_benchmark(bool quick, const Path& folder);
/// Writes <name>.json and plots into `folder` unless it is empty. Throws UserError for a name that is not known.
[[nodiscard]] Json run_benchmark(const std::string& name, const std::vector<Path>& cases, const Path& folder, bool quick);

}  // namespace porepack
