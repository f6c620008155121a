// Which scan is good enough? Scans of a packing simulated at several settings, its grains fitted, porosity and k compared with the truth.
#pragma once

#include <vector>

#include "analysis/outcome.hpp"
#include "core/files.hpp"
#include "results/scan_plan.hpp"
#include "scans/scanner.hpp"

namespace porepack::analysis {

struct ScanPlanConfig {
    std::vector<double> voxel_sizes_m = {};
    std::vector<double> views = {};
    std::vector<double> counts = {};
    double within = 0.01;
};
inline void describe(record::ConfigVisitor& v, ScanPlanConfig& c) {
    v.numbers("voxel_sizes_m", c.voxel_sizes_m, {0, 20}, record::length_range(),
              "voxel sizes to try; auto: 1/12, 1/8 and 1/6 of the thinnest capsule's diameter");
    v.numbers("views", c.views, {0, 20}, record::between(0.0, 20000.0),
              "numbers of projections to try (0: 1.6 per pixel of a detector row); auto: 0");
    v.numbers("counts", c.counts, {0, 20}, record::between(0.0, 1e9),
              "photons per pixel and view to try (0: no noise); auto: 20000 and 2000");
    v.number("within", c.within, record::between(1e-5, 1.0), "wanted largest relative error of k");
}

/// Combinations of the values to try; an empty list counts with its standard values.
[[nodiscard]] std::size_t number_of_scans(const ScanPlanConfig& config);

/// Every combination, of the scanner's other properties in `scanner`, with the table plan.csv; `folder` is for files on the way. k by the
/// lattice Boltzmann method on one grid of 10 voxels per capsule diameter, the same for truth and fit: its discretisation error cancels,
/// which leaves the error of the scan. Throws UserError where the part is not longer than two grains.
[[nodiscard]] Outcome<results::ScanPlan> plan_scan(const packing::Packing& packing, const packing::Section& part,
                                                   const scans::ScannerConfig& scanner, const ScanPlanConfig& config,
                                                   const core::Path& folder);

}  // namespace porepack::analysis
