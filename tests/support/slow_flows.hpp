// Random flows that are slow to become steady, for tests of the iteration error. Lengths in units of the box's width.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lbm/permeability.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::test {

struct SlowFlow {
    std::string name;
    pore_space::PoreSpace space;
    double voxel_size_m = 0.0;
    double relaxation_time = 1.2;
    lbm::Precision precision = lbm::Precision::double_precision;
    bool from_coarser_grid = false;  ///< starts from the flow on voxels 1.5 times as large, otherwise it starts from rest
};

/// The kinds alternate: narrow gaps between wide chambers, long beds, dead-end pores, arrays of spheres in contact, and parallel channels
/// of different width.
[[nodiscard]] std::vector<SlowFlow> random_slow_flows(unsigned seed, int count);

/// A run of a slow flow until k does not change any more.
struct SlowRun {
    std::size_t nodes = 0;
    long steps = 0;
    bool constant = false;  ///< in the last third of the steps k changed by less than 1e-7 (single precision: 1e-5)
    double steady_permeability_lu = 0.0;
    std::vector<lbm::ConvergencePoint> history;
    struct Stop {
        long steps;
        double estimate, error;  ///< relative iteration error of k: reported and true
    };
    /// Where a run with this tolerance ends; nothing if it does not.
    [[nodiscard]] std::optional<Stop> stop(double tolerance) const;
};
[[nodiscard]] SlowRun run_until_constant(const SlowFlow& flow, long max_steps);

}  // namespace porepack::test
