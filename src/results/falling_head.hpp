// The simulated falling-head test and its causes of error: results/{falling-head,causes}/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/json.hpp"
#include "core/members.hpp"
#include "falling_head/causes.hpp"

namespace porepack::results {

/// k of a bed of these grains; none of an image, which has none.
struct Correlations {
    core::OptionalKey<double> carman_kozeny_150_m2 = {}, carman_kozeny_180_m2 = {};
    core::OptionalKey<double> paper_fit_m2 = {};  ///< of grains of the paper's volume
};
template <core::MembersOf<Correlations> Self, typename Visit>
void visit_members(Self& correlations, const Visit& visit) {
    visit("carman_kozeny_150_m2", correlations.carman_kozeny_150_m2);
    visit("carman_kozeny_180_m2", correlations.carman_kozeny_180_m2);
    visit("paper_fit_m2", correlations.paper_fit_m2);
}

struct FallingHead {
    static constexpr const char* stage = "falling-head";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    double permeability_m2 = 0.0;
    double inertial_permeability_m = 0.0;  ///< infinite: Darcy's law alone
    double sample_length_m = 0.0, start_level_m = 0.0;
    std::optional<double> inertia_coefficient{};  ///< total, 1 for a plain column; none: without inertia of the water
    std::vector<double> levels_m;
    std::vector<double> times_s;                               ///< Eq. 18
    std::vector<std::optional<double>> times_full_equation_s;  ///< with inertia and wire screens; none: the level is not passed
    double start_speed_m_per_s = 0.0;
    core::OptionalKey<std::string> warning = {};
    std::string equation;
    core::OptionalKey<double> frames_per_s = {}, noise_m = {};  ///< of falling_head.csv
    // Of a case.
    core::OptionalKey<std::string> permeability_from = {}, inertial_permeability_from = {};
    core::OptionalKey<Correlations> correlations = {};
};
template <core::MembersOf<FallingHead> Self, typename Visit>
void visit_members(Self& test, const Visit& visit) {
    visit("permeability_m2", test.permeability_m2);
    visit("inertial_permeability_m", test.inertial_permeability_m);
    visit("sample_length_m", test.sample_length_m);
    visit("start_level_m", test.start_level_m);
    visit("inertia_coefficient", test.inertia_coefficient);
    visit("levels_m", test.levels_m);
    visit("times_s", test.times_s);
    visit("times_full_equation_s", test.times_full_equation_s);
    visit("start_speed_m_per_s", test.start_speed_m_per_s);
    visit("warning", test.warning);
    visit("equation", test.equation);
    visit("frames_per_s", test.frames_per_s);
    visit("noise_m", test.noise_m);
    visit("permeability_from", test.permeability_from);
    visit("inertial_permeability_from", test.inertial_permeability_from);
    visit("correlations", test.correlations);
}

/// Factors are k true / k by the paper's evaluation; none: it gives no k.
struct Cause {
    std::string cause, what;
    core::Interval range;
    std::string unit;
    std::array<std::optional<double>, 2> factors{};  ///< at both ends of the range
    std::string source, evidence;
};
template <core::MembersOf<Cause> Self, typename Visit>
void visit_members(Self& cause, const Visit& visit) {
    visit("cause", cause.cause);
    visit("what", cause.what);
    visit("range", cause.range);
    visit("unit", cause.unit);
    visit("factors", cause.factors);
    visit("source", cause.source);
    visit("evidence", cause.evidence);
}

/// All causes at random.
struct JointCauses {
    std::string what;
    double range_factor = 1.0;
    long draws = 0;
    double without_k = 0.0;  ///< share of the draws
    std::optional<double> median{};
    std::array<std::optional<double>, 2> interval{};
    std::optional<double> reaches{};  ///< share of the draws with at least the factor to be explained
};
template <core::MembersOf<JointCauses> Self, typename Visit>
void visit_members(Self& joint, const Visit& visit) {
    visit("what", joint.what);
    visit("range_factor", joint.range_factor);
    visit("draws", joint.draws);
    visit("without_k", joint.without_k);
    visit("median", joint.median);
    visit("interval", joint.interval);
    visit("reaches", joint.reaches);
}

/// At both ends of the window.
struct ReynoldsOfTest {
    std::array<double, 2> by_grain_diameter{}, by_tube_diameter{};
};
template <core::MembersOf<ReynoldsOfTest> Self, typename Visit>
void visit_members(Self& reynolds, const Visit& visit) {
    visit("by_grain_diameter", reynolds.by_grain_diameter);
    visit("by_tube_diameter", reynolds.by_tube_diameter);
}

/// What would change the computed k, not the measured one.
struct ComputationEffects {
    double paper_scheme_over_porepack = 0.0, core_over_tube = 0.0;
};
template <core::MembersOf<ComputationEffects> Self, typename Visit>
void visit_members(Self& effects, const Visit& visit) {
    visit("paper_scheme_over_porepack", effects.paper_scheme_over_porepack);
    visit("core_over_tube", effects.core_over_tube);
}

struct Causes {
    static constexpr const char* stage = "causes";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    double permeability_m2 = 0.0, inertial_permeability_m = 0.0;
    double porosity_central = 0.0;
    double inertia_coefficient = 1.0;
    std::vector<double> porosity_layers;
    double viscous_share_of_head = 0.0;
    ReynoldsOfTest reynolds = {};
    double evaluation_alone = 1.0;  ///< factor where Eq. 18 holds exactly
    double darcy_alone = 1.0;
    std::optional<double> to_explain{};  ///< k computed / k measured
    std::string factor_is = "k true / k by the paper's evaluation";
    falling_head::SampleTruth sample = {};
    core::Json apparatus;  ///< resolved [falling_head]
    std::vector<Cause> causes;
    std::vector<JointCauses> joint;
    ComputationEffects computation = {};
    std::string inertial_permeability_from;
};
template <core::MembersOf<Causes> Self, typename Visit>
void visit_members(Self& causes, const Visit& visit) {
    visit("permeability_m2", causes.permeability_m2);
    visit("inertial_permeability_m", causes.inertial_permeability_m);
    visit("porosity_central", causes.porosity_central);
    visit("inertia_coefficient", causes.inertia_coefficient);
    visit("porosity_layers", causes.porosity_layers);
    visit("viscous_share_of_head", causes.viscous_share_of_head);
    visit("reynolds", causes.reynolds);
    visit("evaluation_alone", causes.evaluation_alone);
    visit("darcy_alone", causes.darcy_alone);
    visit("to_explain", causes.to_explain);
    visit("factor_is", causes.factor_is);
    visit("sample", causes.sample);
    visit("apparatus", causes.apparatus);
    visit("causes", causes.causes);
    visit("joint", causes.joint);
    visit("computation", causes.computation);
    visit("inertial_permeability_from", causes.inertial_permeability_from);
}

}  // namespace porepack::results
