// Random series of flows with inertia, for tests of the iteration error.
#pragma once

#include <string>
#include <vector>

#include "support/slow_flows.hpp"

namespace porepack::test {

struct InertialRun {
    std::string name;
    double reynolds = 0.0;
    SlowRun run;  ///< until the estimated error is the tolerance
};
/// Three flows of each series, each of which starts from the one before: cubic arrays of spheres, random spheres, overlapping tetrapods,
/// and layers of spheres between water, in turn; from 8 nodes per diameter on, Re 0.5 to 80. Flows that do not become steady are left out.
[[nodiscard]] std::vector<InertialRun> random_inertial_runs(unsigned seed, int series, double finest_nodes_per_diameter, double tolerance);

}  // namespace porepack::test
