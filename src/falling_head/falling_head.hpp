// The falling-head test by the paper's Eq. 18, in closed form.
#pragma once

#include "falling_head/config.hpp"

namespace porepack::falling_head {

/// Falling head, Eq. 18: g (h + L)/L = (nu/k) v + v^2/k_in with v = -dh/dt, without the inertia of the water column.
/// Solved in closed form through x + ln x = y, which does not overflow.
class FallingHead {
public:
    /// `inertial_permeability_m` may be infinite (Darcy only). Throws UserError unless both are positive.
    FallingHead(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config);

    [[nodiscard]] double speed_at(double level_m) const;
    /// Time at which the water level passes `level_m`. Throws UserError for a level above the start level.
    [[nodiscard]] double time_at(double level_m) const;
    [[nodiscard]] double level_at(double time_s) const;

private:
    double A_, B_, g_, L_, start_speed_, start_;
};

/// Solves x + ln x = y for x > 0.
[[nodiscard]] double solve_x_plus_log_x(double y);

}  // namespace porepack::falling_head
