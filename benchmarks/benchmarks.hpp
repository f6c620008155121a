// Measurements: they report, they do not judge.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "openfoam/foam.hpp"

namespace porepack {

/// Whether intervals cover, for LbmConfig::tolerance; a row for each tolerance and each flow.
[[nodiscard]] Json coverage_benchmark(const std::vector<unsigned>& seeds, const std::vector<double>& tolerances);
/// Speed of the kernels against the memory's limit, steps of the schemes to the same tolerance, error against seconds.
[[nodiscard]] Json lbm_benchmark(const Path& folder);
/// Runs both flow solvers of the cases as far as that is not done, and compares k, cost and mean profiles of the speed.
[[nodiscard]] Json cross_check_benchmark(const std::vector<Path>& cases, const Path& folder);
/// OpenFOAM on flows of known answer; its cases lie in `folder` (or ./foam_verification).
[[nodiscard]] Json foam_benchmark(const Path& folder);
/// A packing as OpenFOAM takes it; `deviation` of its surface over the grain's size.
[[nodiscard]] FoamScene foam_scene_of(const Packing& packing, const Section& section, double grain_size_m, double deviation = 0.003);
/// Both packing engines: porosity of several packings, seconds against the clumps' surface tolerance; writes packing_engines.svg into
/// `folder`.
[[nodiscard]] Json packing_benchmark(bool quick, const Path& folder);
/// The paper's tortuosity against all it depends on, error against seconds of the others; writes tortuosity_study.svg into `folder`.
[[nodiscard]] Json tortuosity_benchmark(bool quick, const Path& folder);
/// Error against cost of both solvers and the paper's scheme; writes speed_error.svg and .csv into `folder` (or ./speed_error).
[[nodiscard]] Json speed_error_benchmark(bool quick, const Path& folder);
/// Error and time of the measures of shapes against tolerance, of the inverse, and of CGAL's surfaces against their number of triangles.
[[nodiscard]] Json shapes_benchmark();

}  // namespace porepack
