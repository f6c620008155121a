// The reverse question: which shape gives this permeability at this porosity?
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/files.hpp"
#include "core/interval.hpp"
#include "core/json_fwd.hpp"
#include "core/members.hpp"
#include "core/sides.hpp"
#include "design/candidates.hpp"

namespace porepack::design {

/// What is wanted, and among what. Intervals with low = high are single values.
struct DesignGoal {
    core::Interval permeability_m2;
    std::optional<core::Interval> porosity;    ///< none: any
    vessels::Container container;              ///< of the finished bed
    double volume_m3 = 0.0;                    ///< of a grain; 0: free
    std::vector<shapes::ShapeKind> kinds;      ///< presets to choose from
    core::Path own_shape;                      ///< TOML file with [[capsule]] tables; empty: none
    std::vector<FreeParameter> free;           ///< of own_shape
    core::Interval sphericity = {0.43, 0.99};  ///< of presets
    core::Interval convexity = {0.0, 1.0};
    double thinnest_m = 0.0;                ///< smallest capsule diameter allowed
    core::Interval mass_kg = {0.0, 1e300};  ///< of a grain
    long packings = 3;                      ///< of each proposal, with seeds from `seed` on; more where the interval is too wide for a hit
    long seed = 101;
    long max_proposals = 6;
    double within = 0.2;      ///< largest relative half width of an interval that counts as a hit
    double max_time_s = 0.0;  ///< no proposal begins after this time, and none gets more packings; 0: no limit
    bool full = false;        ///< pour the answer in the whole container, too
    core::Path study;         ///< whose table the search starts from; its base case is the bed that is poured
};
[[nodiscard]] core::Json to_json(const DesignGoal& goal);

/// A grain of a size, and what is expected of its bed.
struct SizedCandidate {
    Candidate candidate;
    double size_m = 0.0;    ///< d_v
    double bed_wall = 0.0;  ///< d_v / diameter of the bed that is poured, at most its container's
    Prediction prediction;
    double chance = 0.0;    ///< that the computed bed meets the goal
    double distance = 0.0;  ///< of the goal from the prediction, in standard deviations
};

/// A bed that was poured and solved.
struct Proposal {
    SizedCandidate grain;
    std::string error = {};  ///< why it could not be computed; the other members are then 0
    KnownBed bed = {};
    long magnified_from = 0;  ///< number of the proposal whose bed this one is, magnified with its container; 0: poured
    double permeability_m2 = 0.0;
    /// Of 95 %, of the means of such packings, from their scatter and that of all beds known.
    core::Interval permeability_interval_m2 = {}, porosity_interval = {};
    /// The wider side of the interval of k, relative.
    [[nodiscard]] double permeability_half_width() const {
        return core::half_widths(permeability_m2, permeability_interval_m2).wider() / permeability_m2;
    }
    bool hit = false;
};

enum class Verdict { hit, out_of_reach, not_hit };
constexpr std::array<core::Choice<Verdict>, 3> choices_of(Verdict) {
    return {{{Verdict::hit, "hit"}, {Verdict::out_of_reach, "out_of_reach"}, {Verdict::not_hit, "not_hit"}}};
}

/// The answer in the whole container.
struct FullBed {
    double permeability_m2 = 0.0;
    std::optional<core::Interval> permeability_interval_m2{};  ///< numerical
    double porosity = 0.0;
    double over_goal = 0.0;  ///< k over the middle of the goal
};
template <core::MembersOf<FullBed> Self, typename Visit>
void visit_members(Self& full, const Visit& visit) {
    visit("permeability_m2", full.permeability_m2);
    visit("permeability_interval_m2", full.permeability_interval_m2);
    visit("porosity", full.porosity);
    visit("over_goal", full.over_goal);
}

struct DesignResult {
    Verdict verdict = Verdict::not_hit;
    std::vector<Proposal> proposals;
    std::string text;                       ///< the answer in a few sentences
    std::optional<FullBed> full = {};       ///< if asked for, and a proposal is a hit
    std::vector<SizedCandidate> reachable;  ///< all candidates with what is expected of them after the last proposal
};

/// Proposes, pours, solves and learns until a proposal is a hit, the goal is out of reach, or max_proposals have been computed. Proposals
/// are cases in folder/proposal_<n>; those that are done are not computed again. Writes proposals.csv, design.json and design.html.
/// Throws UserError for a goal that cannot be searched for.
DesignResult run_design(const DesignGoal& goal, const core::Path& folder);

/// The first proposal with what is expected of it and its cost, and the values that can be reached. Nothing is written.
[[nodiscard]] core::Json plan_design(const DesignGoal& goal);

}  // namespace porepack::design
