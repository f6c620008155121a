// How much each cause changes the k that the paper's evaluation gives: curves are simulated with the cause and evaluated without
// knowing of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "falling_head/column.hpp"
#include "falling_head/level_curve.hpp"

namespace porepack::falling_head {

/// The sample as it is taken to be.
struct SampleTruth {
    double permeability_m2 = 0.0, inertial_permeability_m = 0.0, porosity = 1.0;
    /// Mean over the whole sample of what the structure at its ends does to 1/k and 1/k_in of the central section.
    double ends_viscous = 1.0, ends_inertial = 1.0;
    /// The same if the lowest layer, one grain's diameter high, is denser than the rest (aligned at the mesh).
    double aligned_viscous = 1.0, aligned_inertial = 1.0;
};

struct Cause {
    std::string name, what;
    std::optional<double> factor;  ///< k true / k evaluated; none where the evaluation fails
    double low = 0.0, high = 0.0;  ///< of noise: 16 and 84 %; else both the factor
    std::string note = {};         ///< why there is no factor, or of how many trials
};

struct CauseStudy {
    std::vector<Cause> causes, together;
    /// Level offset at which the paper's evaluation is off by `factor`, alone and with the water's inertia and the meshes; none within 30
    /// mm.
    std::optional<double> explaining_offset_m, explaining_offset_with_all_m;
    double viscous_share = 0.0;  ///< of the head at the middle of the window
};

/// `config` is the apparatus as it is assumed to be: meshes and inertia count as causes. `factor` is what has to be explained (k computed /
/// k measured); 0: nothing.
[[nodiscard]] CauseStudy study_causes(const SampleTruth& truth, const FallingHeadConfig& config, double factor);

/// Level against time from the opening of the outlet until the window's end, with the config's noise.
[[nodiscard]] LevelCurve simulate_curve(const Resistance& resistance, const FallingHeadConfig& config);

/// What a porosity profile does to the mean of 1/k and 1/k_in, in proportion to that of the porosity `central`: by the equations of
/// Carman-Kozeny, (1 - e)^2/e^3, and Ergun, (1 - e)/e^3.
struct ProfileFactors {
    double viscous = 1.0, inertial = 1.0;
};
[[nodiscard]] ProfileFactors profile_factors(const std::vector<double>& layers, double central);

}  // namespace porepack::falling_head
