// A falling-head curve evaluated as in the paper (2.2.3), step by step.
#pragma once

#include <array>
#include <string>

#include "falling_head/level_curve.hpp"

namespace porepack::falling_head {

/// 1. A quadratic is fitted to h(t). 2. Eq. 19, that is Eq. 18 at two times, half the curve's duration apart, gives k and k_in; the paper
/// does not name the times. 3. k_in is averaged. 4. With it Eq. 18 gives k at every time. 5. That is averaged.
/// Inertia of the water, wire screens and noise are not considered; no uncertainty is known.
struct PaperEvaluation {
    std::array<double, 3> quadratic{};  ///< h = q0 + q1 t + q2 t^2, metres and seconds from the first point
    double quadratic_residual_m = 0.0;  ///< root mean square
    double inertial_permeability_m = 0.0;
    double permeability_m2 = 0.0;
    double lowest_m2 = 0.0, highest_m2 = 0.0;  ///< k over time
    bool sound = false;                        ///< true if all steps gave positive numbers; else permeability_m2 must not be used
    std::string fault = {};
};

[[nodiscard]] PaperEvaluation evaluate_as_paper(const LevelCurve& curve, const FallingHeadConfig& config);

}  // namespace porepack::falling_head
