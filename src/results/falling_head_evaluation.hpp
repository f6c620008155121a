// Measured falling-head curves, a planned test, and what two tests have in common: `porepack falling-head analyse`, `plan`,
// `common-causes`.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

/// As in the paper; k and k_in are none where the evaluation gives none.
struct PaperFit {
    std::optional<double> permeability_m2{};
    std::optional<double> inertial_permeability_m{};
    core::Interval permeability_over_time_m2;  ///< lowest and highest
    std::array<double, 3> quadratic{};         ///< h = q0 + q1 t + q2 t^2, from the first point
    double quadratic_residual_m = 0.0;
    std::optional<double> uncertainty{};  ///< the paper gives none
    std::optional<std::string> fault{};
};
template <core::MembersOf<PaperFit> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("permeability_m2", found.permeability_m2);
    visit("inertial_permeability_m", found.inertial_permeability_m);
    visit("permeability_over_time_m2", found.permeability_over_time_m2);
    visit("quadratic", found.quadratic);
    visit("quadratic_residual_m", found.quadratic_residual_m);
    visit("uncertainty", found.uncertainty);
    visit("fault", found.fault);
}

/// Fitted within their uncertainties.
struct FittedApparatus {
    double level_offset_m = 0.0;
    double scale_error = 0.0;
    double kinematic_viscosity_m2_per_s = 0.0;
    double inertia_coefficient = 0.0;
    double inertial_exponent = 0.0;
};
template <core::MembersOf<FittedApparatus> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("level_offset_m", found.level_offset_m);
    visit("scale_error", found.scale_error);
    visit("kinematic_viscosity_m2_per_s", found.kinematic_viscosity_m2_per_s);
    visit("inertia_coefficient", found.inertia_coefficient);
    visit("inertial_exponent", found.inertial_exponent);
}

/// Of one curve, or of all of a packing. An interval without a bound is open on that side.
struct LeastSquaresFit {
    std::optional<double> permeability_m2{};
    core::Interval permeability_interval_m2;
    double inverse_permeability_per_m2 = 0.0;
    core::Interval inverse_permeability_interval_per_m2;
    std::optional<double> inertial_permeability_m{};
    core::Interval inverse_inertial_permeability_interval_per_m;
    double correlation = 0.0;  ///< of 1/k and 1/k_in
    double viscous_share_of_head = 0.0;
    FittedApparatus fitted_within_uncertainty = {};
    double residual_correlation = 0.0;  ///< between neighbouring frames
    double intervals_widened = 0.0;     ///< over those of noise that is independent from frame to frame
    double slow_noise_probability = 0.0;
    double intervals_widened_if_slow = 0.0;
    double residual_m = 0.0;
    double noise_m = 0.0;
    long points = 0;
    std::string verdict;
    std::string verdict_inertial;
};
template <core::MembersOf<LeastSquaresFit> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("permeability_m2", found.permeability_m2);
    visit("permeability_interval_m2", found.permeability_interval_m2);
    visit("inverse_permeability_per_m2", found.inverse_permeability_per_m2);
    visit("inverse_permeability_interval_per_m2", found.inverse_permeability_interval_per_m2);
    visit("inertial_permeability_m", found.inertial_permeability_m);
    visit("inverse_inertial_permeability_interval_per_m", found.inverse_inertial_permeability_interval_per_m);
    visit("correlation", found.correlation);
    visit("viscous_share_of_head", found.viscous_share_of_head);
    visit("fitted_within_uncertainty", found.fitted_within_uncertainty);
    visit("residual_correlation", found.residual_correlation);
    visit("intervals_widened", found.intervals_widened);
    visit("slow_noise_probability", found.slow_noise_probability);
    visit("intervals_widened_if_slow", found.intervals_widened_if_slow);
    visit("residual_m", found.residual_m);
    visit("noise_m", found.noise_m);
    visit("points", found.points);
    visit("verdict", found.verdict);
    visit("verdict_inertial", found.verdict_inertial);
}

struct AnalysedCurve {
    std::string file;
    std::string packing;
    PaperFit as_the_paper = {};
    LeastSquaresFit least_squares = {};
};
template <core::MembersOf<AnalysedCurve> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("file", found.file);
    visit("packing", found.packing);
    visit("as_the_paper", found.as_the_paper);
    visit("least_squares", found.least_squares);
}

/// Over the curves of which the evaluation gives k.
struct PaperMean {
    std::optional<double> permeability_m2{};
    std::optional<double> standard_deviation_m2{};
    std::size_t curves = 0;
    std::size_t curves_without_k = 0;
};
template <core::MembersOf<PaperMean> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("permeability_m2", found.permeability_m2);
    visit("standard_deviation_m2", found.standard_deviation_m2);
    visit("curves", found.curves);
    visit("curves_without_k", found.curves_without_k);
}

struct AnalysedPacking {
    std::string packing;
    std::size_t curves = 0;
    LeastSquaresFit least_squares = {};
};
template <core::MembersOf<AnalysedPacking> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("packing", found.packing);
    visit("curves", found.curves);
    visit("least_squares", found.least_squares);
}

/// Standard deviations of the fits of single curves within a packing, and of the packings' means.
struct ScatterOfFits {
    double mean = 0.0;  ///< over the packings
    std::optional<double> within_packings{};
    std::optional<double> between_packings{};
};
template <core::MembersOf<ScatterOfFits> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("mean", found.mean);
    visit("within_packings", found.within_packings);
    visit("between_packings", found.between_packings);
}

struct CurvesScatter {
    std::size_t curves = 0;
    std::size_t packings = 0;
    ScatterOfFits inverse_permeability_per_m2 = {};
    ScatterOfFits inverse_inertial_permeability_per_m = {};
    std::string meaning =
        "mean over the packings; standard deviations of the fits of single curves within a packing, and of the packings' means";
};
template <core::MembersOf<CurvesScatter> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("curves", found.curves);
    visit("packings", found.packings);
    visit("inverse_permeability_per_m2", found.inverse_permeability_per_m2);
    visit("inverse_inertial_permeability_per_m", found.inverse_inertial_permeability_per_m);
    visit("meaning", found.meaning);
}

struct FallingHeadAnalysis {
    std::vector<double> window_m;
    double sample_length_m = 0.0;
    bool column_inertia = false;
    std::optional<double> inertia_coefficient{};  ///< with column_inertia
    std::string intervals_hold =
        "noise (with its correlation between frames), and what has an uncertainty: level offset, scale, viscosity, inertia coefficient, "
        "inertial exponent; sample_length_m and the screens are taken as given";
    std::vector<std::string> warnings;
    std::vector<AnalysedCurve> curves;
    PaperMean as_the_paper = {};
    std::vector<AnalysedPacking> packings;
    CurvesScatter scatter = {};
    core::OptionalKey<std::string> verdict = {};  ///< of one packing
    core::OptionalKey<std::string> verdict_inertial = {};
};
template <core::MembersOf<FallingHeadAnalysis> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("window_m", found.window_m);
    visit("sample_length_m", found.sample_length_m);
    visit("column_inertia", found.column_inertia);
    visit("inertia_coefficient", found.inertia_coefficient);
    visit("intervals_hold", found.intervals_hold);
    visit("warnings", found.warnings);
    visit("curves", found.curves);
    visit("as_the_paper", found.as_the_paper);
    visit("packings", found.packings);
    visit("scatter", found.scatter);
    visit("verdict", found.verdict);
    visit("verdict_inertial", found.verdict_inertial);
}

struct PlannedTest {
    double glycerol_fraction = 0.0;
    double kinematic_viscosity_m2_per_s = 0.0;
    double sample_length_m = 0.0;
    std::vector<double> window_m;
    double duration_s = 0.0;
    double fastest_m_per_s = 0.0;
    double viscous_share_of_head = 0.0;
    std::optional<double> half_width_k{};  ///< relative, of 1/k; none: its interval has an open end
    std::optional<double> half_width_k_in{};
};
template <core::MembersOf<PlannedTest> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("glycerol_fraction", found.glycerol_fraction);
    visit("kinematic_viscosity_m2_per_s", found.kinematic_viscosity_m2_per_s);
    visit("sample_length_m", found.sample_length_m);
    visit("window_m", found.window_m);
    visit("duration_s", found.duration_s);
    visit("fastest_m_per_s", found.fastest_m_per_s);
    visit("viscous_share_of_head", found.viscous_share_of_head);
    visit("half_width_k", found.half_width_k);
    visit("half_width_k_in", found.half_width_k_in);
}

struct FallingHeadPlan {
    double within = 0.0;                    ///< wanted half width of 1/k
    std::optional<PlannedTest> cheapest{};  ///< that reaches it
    std::optional<PlannedTest> narrowest{};
    std::string verdict;
    std::vector<PlannedTest> tests;
    std::string meaning =
        "half_width: the wider side of the 95 % interval of 1/k and 1/k_in, relative, of simulated tests with this noise and these "
        "uncertainties; null: the interval has an open end. Cheaper is: less glycerol, then a shorter sample, then a lower column";
};
template <core::MembersOf<FallingHeadPlan> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("within", found.within);
    visit("cheapest", found.cheapest);
    visit("most_certain", found.narrowest);
    visit("verdict", found.verdict);
    visit("tests", found.tests);
    visit("meaning", found.meaning);
}

/// Shares of the draws, of each of two samples and of both in the same draw.
struct CommonShares {
    std::size_t draws = 0;
    std::array<std::optional<double>, 2> medians{};
    std::array<double, 2> reach{};  ///< have at least the factor to be explained
    double reach_both = 0.0;
    std::array<double, 2> near{};  ///< are near it
    double near_both = 0.0;
};
template <core::MembersOf<CommonShares> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("draws", found.draws);
    visit("medians", found.medians);
    visit("reach", found.reach);
    visit("reach_both", found.reach_both);
    visit("near", found.near);
    visit("near_both", found.near_both);
}

struct CommonByExponent {
    CommonShares shares = {};
    core::Interval exponent;  ///< of the falling inertial coefficient
};
template <core::MembersOf<CommonByExponent> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("", found.shares);
    visit("exponent", found.exponent);
}

/// Of one width of the ranges.
struct CommonPairs {
    CommonShares shares = {};
    double range_factor = 0.0;
    std::optional<double> correlation{};  ///< of the logarithms of both factors
    std::vector<CommonByExponent> by_exponent;
};
template <core::MembersOf<CommonPairs> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("", found.shares);
    visit("range_factor", found.range_factor);
    visit("correlation", found.correlation);
    visit("by_exponent", found.by_exponent);
}

struct CommonCauses {
    std::array<std::string, 2> samples{};
    std::array<double, 2> to_explain{};
    std::vector<std::string> common;  ///< causes that are the same for both
    double near_within_factor = 0.0;
    std::vector<CommonPairs> pairs;
    std::string meaning =
        "each draw puts the common causes at the same place of their ranges for both samples, and draws the others for each. reach: share "
        "of all draws with at least the factor; near: within the factor near_within_factor of it; both: in the same draw";
};
template <core::MembersOf<CommonCauses> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("samples", found.samples);
    visit("to_explain", found.to_explain);
    visit("common", found.common);
    visit("near_within_factor", found.near_within_factor);
    visit("pairs", found.pairs);
    visit("meaning", found.meaning);
}

}  // namespace porepack::results
