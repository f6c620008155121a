#include "falling_head/falling_head.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace porepack::falling_head {

double solve_x_plus_log_x(double y) {
    // Newton in u = ln x: exp(u) + u = y is convex and increasing; the initial value is close to the root on both branches.
    double u = y < 1.0 ? y - std::exp(std::min(y, 0.0)) * (y < 0.0 ? 1.0 : 0.4) : std::log(y);
    for (int i = 0; i < 60; ++i) {
        const double e = std::exp(u);
        const double step = (e + u - y) / (e + 1.0);
        u -= step;
        if (std::abs(step) < 1e-16 * (1.0 + std::abs(u))) break;
    }
    return std::exp(u);
}

// With A = nu/k and B = 1/k_in: t = (L/g) (A ln(v0/v) + 2 B (v0 - v)).
FallingHead::FallingHead(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config)
    : A_(config.kinematic_viscosity_m2_per_s / permeability_m2),
      B_(1.0 / inertial_permeability_m),
      g_(config.gravity_m_per_s2),
      L_(config.sample_length_m),
      start_speed_(0.0),
      start_(config.start_level_m) {
    if (!(permeability_m2 > 0.0) || !std::isfinite(permeability_m2))
        throw UserError(fmt::format("the permeability must be positive, got {:g} m2", permeability_m2));
    if (!(inertial_permeability_m > 0.0))
        throw UserError(fmt::format("the inertial permeability must be positive, got {:g} m", inertial_permeability_m),
                        {.allowed = "> 0, or inf for Darcy's law alone"});
    start_speed_ = speed_at(start_);
}

double FallingHead::speed_at(double level_m) const {
    const double head = g_ * (level_m + L_) / L_;
    return 2.0 * head / (A_ + std::sqrt(A_ * A_ + 4.0 * B_ * head));  // no cancellation for small B
}

// Eq. (T24).
double FallingHead::time_at(double level_m) const {
    if (level_m > start_)
        throw UserError(fmt::format("the water level {:g} m is above the start level {:g} m", level_m, start_),
                        {.allowed = fmt::format("0 to {:g} m", start_)});
    const double v = speed_at(level_m);
    return L_ / g_ * (A_ * std::log(start_speed_ / v) + 2.0 * B_ * (start_speed_ - v));
}

double FallingHead::level_at(double time_s) const {
    double v = start_speed_ * std::exp(-g_ * time_s / (L_ * A_));
    if (B_ > 0.0) {
        const double x0 = 2.0 * B_ * start_speed_ / A_;
        v = A_ / (2.0 * B_) * solve_x_plus_log_x(x0 + std::log(x0) - g_ * time_s / (L_ * A_));
    }
    return (A_ * v + B_ * v * v) * L_ / g_ - L_;
}

}  // namespace porepack::falling_head
