// What an error or an effect that the paper's evaluation does not know does to its k: curves are simulated with it and evaluated without
// correction for it. Each cause is an uncertain number with a range; alone at both ends, and all together at random.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/members.hpp"
#include "falling_head/column.hpp"
#include "falling_head/level_curve.hpp"

namespace porepack::falling_head {

/// Assumed properties of the sample and its tube.
struct SampleTruth {
    double permeability_m2 = 0.0, inertial_permeability_m = 0.0, porosity = 1.0;
    /// Mean 1/k and 1/k_in of the whole sample, with the structure at its ends, over those of the central section.
    double ends_viscous = 1.0, ends_inertial = 1.0;
    /// The same if the lowest layer, one grain diameter high, is denser than the rest (grains aligned at the wire screen).
    double aligned_viscous = 1.0, aligned_inertial = 1.0;
    double tube_diameter_m = 0.1, grain_diameter_m = 0.01;
    double largest_reynolds = 30.0;                ///< U d/nu of the largest flow from which k_in was computed
    std::optional<double> quasi_steady_inertia{};  ///< <u^2>/(porosity <u_z>^2) of the flow: the largest inertia coefficient
};
template <core::MembersOf<SampleTruth> Self, typename Visit>
void visit_members(Self& truth, const Visit& visit) {
    visit("permeability_m2", truth.permeability_m2);
    visit("inertial_permeability_m", truth.inertial_permeability_m);
    visit("porosity", truth.porosity);
    visit("ends_viscous", truth.ends_viscous);
    visit("ends_inertial", truth.ends_inertial);
    visit("aligned_viscous", truth.aligned_viscous);
    visit("aligned_inertial", truth.aligned_inertial);
    visit("tube_diameter_m", truth.tube_diameter_m);
    visit("grain_diameter_m", truth.grain_diameter_m);
    visit("largest_reynolds", truth.largest_reynolds);
    visit("quasi_steady_inertia", truth.quasi_steady_inertia);
}

/// The simulated test.
struct Scenario {
    FallingHeadConfig apparatus;
    Resistance resistance;
};

/// One cause: a number in a range, of which every value is equally probable.
struct UncertainCause {
    std::string name, what;
    std::string unit;  ///< of `low` and `high`; empty: none
    double low = 0.0, high = 0.0;
    std::string source;   ///< of the range
    bool judged = false;  ///< the range is a judgement
    std::function<void(Scenario&, double)> apply;
    std::optional<double> absent = 0.0;        ///< value without the cause; none: it is always there
    double minimum = -1e300, maximum = 1e300;  ///< beyond them values make no sense, also in wider ranges
    bool common = false;                       ///< the same in tests of different grains in one apparatus
};

/// The causes of one sample in one apparatus, in the order of the report. `config` describes the apparatus as it was built.
[[nodiscard]] std::vector<UncertainCause> uncertain_causes(const SampleTruth& truth, const FallingHeadConfig& config);

/// k true / k by the paper's evaluation; none where the evaluation gives no k.
struct CauseFactors {
    UncertainCause cause;
    std::optional<double> at_low, at_high;  ///< of noise: the 16 and 84 % quantiles of 400 curves with the larger noise
};

/// All causes at once, each at random in its range.
struct JointFactors {
    std::string what;
    double range_factor = 1.0;  ///< of the ranges, about the value without the cause or else their middle
    long draws = 0;
    double without_k = 0.0;                   ///< share of draws in which the evaluation gives no k
    std::optional<double> low, median, high;  ///< 2.5, 50 and 97.5 % of the others
    std::optional<double> reaches;            ///< share of all draws whose factor is at least the one to be explained
    std::vector<double> factors = {};         ///< ascending, of draws with a k
};

struct CauseStudy {
    double evaluation_alone = 1.0;  ///< factor where Eq. 18 holds exactly
    double darcy_alone = 1.0;       ///< factor of an evaluation without inertial term
    std::vector<CauseFactors> causes;
    std::vector<JointFactors> joint;
    double viscous_share = 0.0;                                  ///< fraction of the head at the middle of the window
    double speed_top_m_per_s = 0.0, speed_bottom_m_per_s = 0.0;  ///< of the ideal test at the ends of the window
};

/// `factor` is the factor to be explained (k computed / k measured); 0: none. `draws` for each of three widths of the ranges.
[[nodiscard]] CauseStudy study_causes(const SampleTruth& truth, const FallingHeadConfig& config, double factor, long draws = 2000);

/// A sample, its apparatus, and the factor to be explained.
struct TestedSample {
    SampleTruth truth;
    FallingHeadConfig apparatus;
    double factor = 1.0;
};

/// Two samples tested in one apparatus: in each draw the causes that are common are at the same place in their ranges for both, the others
/// are drawn for each.
struct PairedDraw {
    double exponent = 0.0;                         ///< of the falling inertial coefficient
    std::array<std::optional<double>, 2> factors;  ///< none where the evaluation gives no k
};
struct PairedFactors {
    double range_factor = 1.0;
    std::vector<PairedDraw> draws;
};
/// One entry for each of the widths of the ranges: 1, 1/2 and 2.
[[nodiscard]] std::vector<PairedFactors> study_common_causes(const std::array<TestedSample, 2>& samples, long draws = 2000);

/// Water level against time from the opening of the outlet until the end of the window, with the config's noise.
[[nodiscard]] LevelCurve simulate_curve(const Resistance& resistance, const FallingHeadConfig& config);

/// Mean 1/k and 1/k_in of a porosity profile, relative to their values at the porosity `central`: by the equations of
/// Carman-Kozeny, (1 - e)^2/e^3, and Ergun, (1 - e)/e^3.
struct ProfileFactors {
    double viscous = 1.0, inertial = 1.0;
};
[[nodiscard]] ProfileFactors profile_factors(const std::vector<double>& layers, double central);

/// Viscosity of water at a temperature over that at 20 C, at 1 bar, 0 to 40 C (Kestin, Sokolov & Wakeham 1978).
[[nodiscard]] double water_viscosity_ratio(double temperature_celsius);

}  // namespace porepack::falling_head
