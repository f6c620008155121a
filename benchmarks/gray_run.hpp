// k of a simulated scan by walls from gray values.
#pragma once

#include "converters/simulated_scan.hpp"
#include "lbm/known.hpp"
#include "stages/gray.hpp"

namespace porepack::benchmarks {

struct GrayRun {
    core::GrayImage scan;
    stages::GrayInput input;
    pore_space::PoreSpace space;
    lbm::LbmConfig config;
    lbm::LbmResult result;  ///< with the gray parts of its interval
};
/// The gray levels are given.
[[nodiscard]] GrayRun gray_run(const lbm::KnownFlow& flow, double voxels_per_diameter, const converters::ScanSettings& scan);

}  // namespace porepack::benchmarks
