// The change that each cause makes to k by the paper's evaluation: curves are simulated with the cause and evaluated without
// correction for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "falling_head/column.hpp"
#include "falling_head/level_curve.hpp"

namespace porepack::falling_head {

/// Assumed properties of the sample.
struct SampleTruth {
    double permeability_m2 = 0.0, inertial_permeability_m = 0.0, porosity = 1.0;
    /// Mean 1/k and 1/k_in of the whole sample, with the structure at its ends, over those of the central section.
    double ends_viscous = 1.0, ends_inertial = 1.0;
    /// The same if the lowest layer, one grain diameter high, is denser than the rest (grains aligned at the wire screen).
    double aligned_viscous = 1.0, aligned_inertial = 1.0;
};

struct Cause {
    std::string name, what;
    std::optional<double> factor;  ///< k true / k evaluated; none if the evaluation fails
    double low = 0.0, high = 0.0;  ///< with noise: 16 and 84 % quantiles; else both equal to the factor
    std::string note = {};         ///< why there is no factor, or the number of trials
};

struct CauseStudy {
    std::vector<Cause> causes, together;
    /// Level offset at which the paper's k is wrong by `factor`, alone and with the water's inertia and the wire screens; none within 30
    /// mm.
    std::optional<double> explaining_offset_m, explaining_offset_with_all_m;
    double viscous_share = 0.0;  ///< fraction of the head at the middle of the window
};

/// `config` is the assumed apparatus: wire screens and inertia count as causes. `factor` is the factor to be explained (k computed /
/// k measured); 0: none.
[[nodiscard]] CauseStudy study_causes(const SampleTruth& truth, const FallingHeadConfig& config, double factor);

/// Water level against time from the opening of the outlet until the end of the window, with the config's noise.
[[nodiscard]] LevelCurve simulate_curve(const Resistance& resistance, const FallingHeadConfig& config);

/// Mean 1/k and 1/k_in of a porosity profile, relative to their values at the porosity `central`: by the equations of
/// Carman-Kozeny, (1 - e)^2/e^3, and Ergun, (1 - e)/e^3.
struct ProfileFactors {
    double viscous = 1.0, inertial = 1.0;
};
[[nodiscard]] ProfileFactors profile_factors(const std::vector<double>& layers, double central);

}  // namespace porepack::falling_head
