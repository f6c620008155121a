// How far a least-squares fit may be off where the noise of its points has an unknown correlation over all lags.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace porepack::falling_head {

/// A fit, linear about its solution. The rows are the points of all curves, curve by curve in the order of time, then one row for each
/// prior.
struct LinearisedFit {
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    std::vector<std::vector<double>> times_s;  ///< of each curve
    double prior_deviation = 0.0;              ///< standard deviation of a prior's row, in the unit of the residuals
};

/// Of the 95 % interval of one parameter.
struct HalfWidth {
    double value = 0.0;     ///< of noise and priors together
    double if_slow = 0.0;   ///< the same if the noise certainly has a part with a correlation time above a quarter of the longest curve
    double widening = 1.0;  ///< the noise's part of value, over what it would be if the noise of all points were independent
};

struct NoiseJudgement {
    std::vector<HalfWidth> widths;   ///< of each parameter
    double white_probability = 0.0;  ///< that the noise of all points is independent
    double slow_probability = 0.0;   ///< that it has a part with a correlation time above a quarter of the longest curve
};

/// Of the first `parameters` parameters. The noise is white, or white and correlated in any proportion, with one of two shapes of the
/// correlation and a time between the distance of neighbouring frames and the length of the longest curve. White has the prior probability
/// 3/4; otherwise all correlation times are equally probable. Restricted likelihood (Patterson & Thompson, Biometrika 58 (1971) 545) weighs
/// these models, and with each of them the error of the estimate has a Student's t distribution; the interval is that of their weighted
/// sum. Of a curve with more than 128 frames, the models see means of groups of frames.
[[nodiscard]] NoiseJudgement judge_noise(const LinearisedFit& fit, Eigen::Index parameters);

}  // namespace porepack::falling_head
