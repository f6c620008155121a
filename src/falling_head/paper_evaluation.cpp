#include "falling_head/paper_evaluation.hpp"

#include <fmt/format.h>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>

namespace porepack::falling_head {

PaperEvaluation evaluate_as_paper(const LevelCurve& curve, const FallingHeadConfig& config) {
    const auto n = static_cast<Eigen::Index>(curve.time_s.size());
    Eigen::MatrixX3d powers(n, 3);
    Eigen::VectorXd level(n);
    const double start = curve.time_s.front(), duration = curve.time_s.back() - start;
    for (Eigen::Index i = 0; i < n; ++i) {
        const double t = (curve.time_s[static_cast<std::size_t>(i)] - start) / duration;
        powers.row(i) << 1.0, t, t * t;
        level[i] = curve.level_m[static_cast<std::size_t>(i)];
    }
    const Eigen::Vector3d q = powers.colPivHouseholderQr().solve(level);
    PaperEvaluation result{.quadratic = {q[0], q[1] / duration, q[2] / (duration * duration)}};
    result.quadratic_residual_m = std::sqrt((powers * q - level).squaredNorm() / static_cast<double>(n));
    const double L = config.sample_length_m, nu = config.kinematic_viscosity_m2_per_s, g = config.gravity_m_per_s2;
    const auto speed = [&](double t) { return -(result.quadratic[1] + 2.0 * result.quadratic[2] * t); };
    const auto gradient = [&](double t) {
        return g / L * (result.quadratic[0] + result.quadratic[1] * t + result.quadratic[2] * t * t + L);
    };
    // At evenly spaced times, the same number as frames: gaps have no effect.
    const auto time = [&](Eigen::Index i) { return duration * static_cast<double>(i) / static_cast<double>(n - 1); };
    if (!(speed(0.0) > 0.0) || !(speed(duration) > 0.0)) {
        result.fault = "the fitted quadratic rises at one end";
        return result;
    }
    double sum = 0.0;
    long pairs = 0;
    for (Eigen::Index i = 0; time(i) + 0.5 * duration <= duration * (1.0 + 1e-12); ++i, ++pairs) {
        const double one = time(i), two = one + 0.5 * duration, v1 = speed(one), v2 = speed(two);
        // Eq. 19: gradient / v = nu/k + v/k_in at both times.
        const double inverse = (gradient(one) / v1 - gradient(two) / v2) / (v1 - v2);
        sum += 1.0 / inverse;
    }
    result.inertial_permeability_m = sum / static_cast<double>(pairs);
    if (!(result.inertial_permeability_m > 0.0)) {
        result.fault = fmt::format("Eq. 19 gives an inertial permeability of {:.3g} m", result.inertial_permeability_m);
        return result;
    }
    result.lowest_m2 = 1e300;
    result.highest_m2 = -1e300;
    double mean = 0.0;
    bool negative = false;
    for (Eigen::Index i = 0; i < n; ++i) {
        const double v = speed(time(i)), viscous = gradient(time(i)) - v * v / result.inertial_permeability_m;
        const double k = nu * v / viscous;
        negative = negative || !(viscous > 0.0);
        result.lowest_m2 = std::min(result.lowest_m2, k);
        result.highest_m2 = std::max(result.highest_m2, k);
        mean += k / static_cast<double>(n);
    }
    result.permeability_m2 = mean;
    if (negative)
        result.fault =
            "the paper's evaluation gives no k for this curve: with its mean k_in, no viscous loss is left at some times (Eq. 18)";
    result.sound = result.fault.empty();
    return result;
}

}  // namespace porepack::falling_head
