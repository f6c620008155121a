// Flows that are not steady: their mean in time, with its statistical error. Lattice units.
#pragma once

#include <span>
#include <vector>

#include "lbm/flow.hpp"

namespace porepack::lbm {

/// The mean of a series of correlated samples.
struct SeriesMean {
    double mean = 0.0, deviation = 0.0;  ///< of the samples that count
    std::size_t discarded = 0;           ///< samples at the beginning that are left out
    double correlation = 1.0;  ///< integrated correlation time in samples: n samples tell as much as n / correlation independent ones
    double independent = 0.0;  ///< number of independent samples
    double half_width = 0.0;   ///< of the 95 % interval of the mean (Student's t); infinite below 3 independent samples
};

/// The beginning is left out up to the sample from which on the standard error of the mean is smallest, at most half of the series (White
/// 1997). The correlation time is the sum of the autocorrelations up to five times itself (Sokal 1997).
[[nodiscard]] SeriesMean mean_of_series(std::span<const double> samples);

struct MeanFlowCriterion {
    double tolerance = 0.01;       ///< of the relative half width of the mean velocity; a smaller one takes longer with its inverse square
    double turnover_steps = 1000;  ///< steps in which the mean velocity in the pores passes one grain diameter
    double min_turnovers = 40;     ///< that are always computed: slow fluctuations must have a chance to show
    double max_turnovers = 800;    ///< then the run ends without having met the tolerance
    double steady_change = 1e-4;   ///< a flow whose velocity varies by less than this (relative) over ten turnovers is steady
};

struct MeanFlow {
    double superficial_velocity_lu = 0.0;  ///< mean in time
    double half_width = 0.0;               ///< relative, of its 95 % interval: statistical error, or steady_change of a steady flow
    double fluctuation = 0.0;              ///< standard deviation of the superficial velocity in time over its mean
    double kinetic_energy_factor = 0.0;    ///< <u^2> / <u_z>^2 over the fluid, mean in time
    double lateral_share = 0.0;            ///< mean velocity across the flow / along it: below its statistical error in a symmetric cell
    double correlation_turnovers = 0.0;    ///< integrated correlation time of the velocity
    double fastest_lu = 0.0;               ///< largest velocity on a node in all samples
    bool steady = false;                   ///< the velocity does not change any more
    bool converged = false;                ///< steady, or the tolerance is met
    double turnovers = 0.0;
    long steps = 0;
    double seconds = 0.0;
    std::vector<double> velocity_lu;  ///< superficial velocity, a sample every 1/10 of a turnover
};

/// Steps until the mean of the superficial velocity along the flow is known to the tolerance, in a cell that is periodic along the flow.
/// The mean density, which interpolated walls change slowly, is set back at each sample. Throws FlowDiverged when a velocity is not finite
/// or a node is faster than sound.
[[nodiscard]] MeanFlow average_in_time(Flow& flow, const Domain& domain, double area_cells, const MeanFlowCriterion& criterion);

}  // namespace porepack::lbm
