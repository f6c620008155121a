// The falling-head apparatus as one equation: sample, wire screens, the water's inertia, an offset of the scale.
//   (h + m L) dv/dt = g (h + L) - L (nu v / k + f(v) v^2 / k_in) - (K(v) + K' h) v^2 / 2,  v = -dh/dt
// h = measured level + offset + scale error x (measured level - middle of the window); f = (v / reference speed)^-n above it, else 1; K':
// friction on the tube's wall. The water level h is measured from the sample's upper face; at its lower face the water leaves freely.
// With K = 0 and without the left side this is Eq. 18 of the paper.
#pragma once

#include <span>
#include <vector>

#include "falling_head/config.hpp"

namespace porepack::falling_head {

/// Loss coefficient K of a woven screen of round wires: loss K v^2/2 with the superficial velocity v. Idelchik, Handbook of Hydraulic
/// Resistance, diagram 8-6: K = k_Re (1.3 (1 - f) + (1/f - 1)^2) with the open fraction f of the area and k_Re of Re = (v/f) wire / nu from
/// his table (1.44 at 50, 1 from 1000 on); below 50 22/Re - 22/50 is added, so that it stays continuous (his own formula there is 22/Re
/// plus the quadratic part). `free_fraction` of the openings is not covered by grains.
[[nodiscard]] double screen_loss(double opening_m, double wire_m, double free_fraction, double speed_m_per_s,
                                 double kinematic_viscosity_m2_per_s);

/// Inertia coefficient m: the water in the sample has the inertia of a plain column of m sample lengths. 1.5 if it is not configured.
[[nodiscard]] inline double inertia_coefficient(const FallingHeadConfig& config) {
    return config.inertia_coefficient > 0.0 ? config.inertia_coefficient : 1.5;
}

/// Sample resistances in the form in which they are fitted: the equation is nearly linear in them.
struct Resistance {
    double inverse_permeability_per_m2 = 0.0;          ///< 1/k
    double inverse_inertial_permeability_per_m = 0.0;  ///< 1/k_in
};

class Column {
public:
    /// Throws UserError for a wire screen without open area.
    explicit Column(const FallingHeadConfig& config);

    /// Speed at which the losses equal the head at this measured water level. 0 if the head is not positive.
    [[nodiscard]] double steady_speed(const Resistance& resistance, double level_m) const;

    /// Measured levels (without noise) at increasing `times_s`, with level `level_m` and the water's speed `speed_m_per_s` at `start_s`
    /// (not after the first time). Without the water's inertia the speed follows the level and `speed_m_per_s` is not used. Below the top
    /// of the sample the equation does not hold: the water stops there. Relative error 1e-10; if the water's speed settles within 1/20000
    /// of the time (small k), its inertia is neglected, which changes levels by a fraction of the same size.
    [[nodiscard]] std::vector<double> levels(const Resistance& resistance, double start_s, double level_m, double speed_m_per_s,
                                             std::span<const double> times_s) const;

    /// When the measured level, starting at rest from `start_level_m` at time 0, passes `level_m`; to 1e-9 of it. `guess_s` is a time to
    /// start from. Infinite if it never does.
    [[nodiscard]] double time_at(const Resistance& resistance, double start_level_m, double level_m, double guess_s) const;

    [[nodiscard]] bool has_inertia() const { return config_.column_inertia; }
    [[nodiscard]] const FallingHeadConfig& config() const { return config_; }

private:
    [[nodiscard]] double water_level(double measured_m) const;
    [[nodiscard]] double measured_level(double water_level_m) const;
    [[nodiscard]] double screen_losses(double speed) const;
    [[nodiscard]] double inertial_factor(double speed) const;
    /// Of the terms with the square of the speed: their loss over v^2.
    [[nodiscard]] double quadratic_losses(const Resistance& resistance, double speed, double water_level_m) const;
    [[nodiscard]] double losses(const Resistance& resistance, double speed, double water_level_m) const;
    [[nodiscard]] double speed_at(const Resistance& resistance, double water_level_m) const;

    FallingHeadConfig config_;
    double offset_, inertia_length_;
};

}  // namespace porepack::falling_head
