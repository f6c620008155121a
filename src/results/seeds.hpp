// Several packings of a case: results/seeds/result.json.
#pragma once

#include <optional>
#include <string>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

struct SeedsQuantity {
    std::size_t packings = 0;
    double mean = 0.0;
    std::optional<double> standard_deviation{};
    std::optional<core::Interval> standard_deviation_interval{};
    std::optional<double> numerical_half_width{};                          ///< of one packing, the wider side
    std::optional<core::Interval> numerical_interval{};                    ///< of one packing, about the mean
    std::optional<core::Interval> interval_of_mean{}, interval_of_next{};  ///< of 95 %
};
template <core::MembersOf<SeedsQuantity> Self, typename Visit>
void visit_members(Self& quantity, const Visit& visit) {
    visit("packings", quantity.packings);
    visit("mean", quantity.mean);
    visit("standard_deviation", quantity.standard_deviation);
    visit("standard_deviation_interval", quantity.standard_deviation_interval);
    visit("numerical_half_width", quantity.numerical_half_width);
    visit("numerical_interval", quantity.numerical_interval);
    visit("interval_of_mean", quantity.interval_of_mean);
    visit("interval_of_next", quantity.interval_of_next);
}

/// Pours without a flow.
struct SeedsPours {
    std::size_t packings = 0;
    double relative_deviation_about_line = 0.0, relative_deviation_along_line = 0.0;  ///< of k on the Kozeny function
};
template <core::MembersOf<SeedsPours> Self, typename Visit>
void visit_members(Self& pours, const Visit& visit) {
    visit("packings", pours.packings);
    visit("relative_deviation_about_line", pours.relative_deviation_about_line);
    visit("relative_deviation_along_line", pours.relative_deviation_along_line);
}

struct SeedsFriction {
    double value = 0.0, standard_uncertainty = 0.0, relative_effect_on_permeability = 0.0;
};
template <core::MembersOf<SeedsFriction> Self, typename Visit>
void visit_members(Self& friction, const Visit& visit) {
    visit("value", friction.value);
    visit("standard_uncertainty", friction.standard_uncertainty);
    visit("relative_effect_on_permeability", friction.relative_effect_on_permeability);
}

/// k of the bed whose porosity was measured, by the line of ln k on the logarithm of the Kozeny function.
struct MeasuredBed {
    double porosity = 0.0, standard_uncertainty = 0.0;
    std::string part;
    std::size_t packings = 0;
    std::optional<double> permeability_m2{};
    std::optional<core::Interval> interval_m2{};
    core::OptionalKey<std::string> why = {};                ///< k is not known
    core::OptionalKey<core::Interval> porosity_range = {};  ///< of the packings
    core::OptionalKey<double> slope = {}, standard_deviation_about_line = {}, standard_deviation_of_ln_k = {};
};
template <core::MembersOf<MeasuredBed> Self, typename Visit>
void visit_members(Self& bed, const Visit& visit) {
    visit("porosity", bed.porosity);
    visit("standard_uncertainty", bed.standard_uncertainty);
    visit("part", bed.part);
    visit("packings", bed.packings);
    visit("permeability_m2", bed.permeability_m2);
    visit("interval_m2", bed.interval_m2);
    visit("why", bed.why);
    visit("porosity_range", bed.porosity_range);
    visit("slope", bed.slope);
    visit("standard_deviation_about_line", bed.standard_deviation_about_line);
    visit("standard_deviation_of_ln_k", bed.standard_deviation_of_ln_k);
}

/// Of a study that ends when the mean is sure.
struct UntilSure {
    double until_sure = 0.0;           ///< wanted half width of the mean, relative
    double relative_half_width = 0.0;  ///< reached; infinite of one packing
    bool sure = false;
    std::optional<std::string> stopped_by{};  ///< where it is not
};
template <core::MembersOf<UntilSure> Self, typename Visit>
void visit_members(Self& until, const Visit& visit) {
    visit("until_sure", until.until_sure);
    visit("relative_half_width", until.relative_half_width);
    visit("sure", until.sure);
    visit("stopped_by", until.stopped_by);
}

struct Seeds {
    static constexpr const char* stage = "seeds";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 6;
    std::size_t packings = 0;
    core::ByName<SeedsQuantity> quantities;  ///< results/quantities.hpp
    double porosity_mean = 0.0, porosity_standard_deviation = 0.0;
    double permeability_mean_m2 = 0.0, standard_deviation_between_packings_m2 = 0.0, standard_error_of_mean_m2 = 0.0;
    std::optional<double> numerical_half_width_m2{};
    double unseen_share = 0.0;  ///< packings of another kind, up to this share of all, may be absent with a probability of 5 %
    std::string meaning;
    core::OptionalKey<SeedsPours> pours = {};
    core::OptionalKey<SeedsFriction> friction = {};
    core::OptionalKey<MeasuredBed> measured_porosity = {};
    core::OptionalKey<UntilSure> until_sure = {};
};
template <core::MembersOf<Seeds> Self, typename Visit>
void visit_members(Self& seeds, const Visit& visit) {
    visit("packings", seeds.packings);
    visit("quantities", seeds.quantities);
    visit("porosity_mean", seeds.porosity_mean);
    visit("porosity_standard_deviation", seeds.porosity_standard_deviation);
    visit("permeability_mean_m2", seeds.permeability_mean_m2);
    visit("standard_deviation_between_packings_m2", seeds.standard_deviation_between_packings_m2);
    visit("standard_error_of_mean_m2", seeds.standard_error_of_mean_m2);
    visit("numerical_half_width_m2", seeds.numerical_half_width_m2);
    visit("unseen_share", seeds.unseen_share);
    visit("meaning", seeds.meaning);
    visit("pours", seeds.pours);
    visit("friction", seeds.friction);
    visit("measured_porosity", seeds.measured_porosity);
    visit("", seeds.until_sure);
}

}  // namespace porepack::results
