// k of a simulated scan by walls from gray values.
#pragma once

#include "scans/gray_input.hpp"
#include "support/known_flows.hpp"
#include "support/simulated_scan.hpp"

namespace porepack::benchmarks {

struct GrayRun {
    geometry::GrayImage scan;
    scans::GrayInput input;
    pore_space::PoreSpace space;
    lbm::LbmConfig config;
    lbm::LbmResult result;  ///< with the gray parts of its interval
};
/// The gray levels are given.
[[nodiscard]] GrayRun gray_run(const test::KnownFlow& flow, double voxels_per_diameter, const test::ScanSettings& scan);

}  // namespace porepack::benchmarks
