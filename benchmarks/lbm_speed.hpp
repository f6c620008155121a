// Speed of the lattice Boltzmann kernels against what limits them.
#pragma once

#include <string>

#include "benchmarks/benchmarks.hpp"
#include "core/json.hpp"

namespace porepack::benchmarks {

/// Spheres that overlap at random.
[[nodiscard]] packing::Packing overlapping_spheres(const std::string& container, double porosity, double radius);

/// Each kind of walls in both precisions, on overlapping spheres of 40 nodes in a periodic box with about `nodes` nodes. Limits, measured
/// beside each: the in-place stream of memory at the bytes that a sweep moves, and the same kernel on a domain that stays in the last
/// cache. Medians of five.
[[nodiscard]] core::Json lbm_speed_rows(double porosity, double nodes);

}  // namespace porepack::benchmarks
