// What the packings of a case tell: the mean, the next one, the effect of friction, and k of a bed whose porosity was measured.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/files.hpp"
#include "core/interval.hpp"
#include "core/sides.hpp"
#include "results/quantities.hpp"
#include "stages/case.hpp"
#include "uncertainty/regression.hpp"

namespace porepack::study {

/// A packing whose flow is known.
struct Member {
    long seed;
    double friction;
    double measured_part_porosity;  ///< of the part whose porosity was measured; NaN where none was, or where it reaches above this bed
    std::array<std::optional<double>, results::reported_quantities.size()> values;
    std::array<std::optional<core::Interval>, results::reported_quantities.size()> intervals;  ///< numerical
    double section_scatter;  ///< predicted from the slices of this packing, relative; NaN where there is no gradient along z
};

/// The packings that are known so far, in the order of their seeds, the case's own first; with until_sure and pours_per_flow above 1 also
/// the porosities of many pours (docs/uncertainty.md). Values are in SI units; intervals are of 95 %.
class KnownPackings {
public:
    /// The case's own packing, whose flow is done.
    explicit KnownPackings(const stages::Case& c);

    void add_flow(const stages::Case& member);
    void add_pour(double porosity) { pours_.push_back(porosity); }
    [[nodiscard]] long flows() const { return static_cast<long>(members_.size()); }
    [[nodiscard]] long pours() const { return static_cast<long>(pours_.size()); }
    [[nodiscard]] double porosity_of_flow(long index) const;

    /// Most pours tell their porosity alone.
    [[nodiscard]] bool many_pours() const { return config_.until_sure > 0.0 && config_.pours_per_flow > 1; }
    [[nodiscard]] long pours_wanted(long flows) const { return many_pours() ? flows * config_.pours_per_flow : 0; }
    /// Number of flows that the first look at the mean needs.
    [[nodiscard]] long flows_of_first_look() const;
    [[nodiscard]] bool enough_for_a_look() const { return flows() >= flows_of_first_look(); }
    [[nodiscard]] double reached() const;  ///< relative half width of the mean k
    [[nodiscard]] bool sure() const;
    /// Packings cannot help: the numerical part alone is too wide.
    [[nodiscard]] bool too_coarse() const;
    /// Number of flows after which the mean is expected to be sure.
    [[nodiscard]] long flows_expected() const;

    void write_tables(const core::Path& folder) const;  ///< seeds.csv, and with many pours pours.csv
    /// Result of the stage (docs/schema); warns of what was asked for and is not known.
    [[nodiscard]] results::Seeds result(bool out_of_time) const;

private:
    struct Estimate {
        double mean, deviation;  // deviation: of one packing
        std::optional<core::Interval> of_mean, of_next;
    };
    [[nodiscard]] std::vector<double> values_of(std::size_t quantity) const;
    [[nodiscard]] uncertainty::Sample sample(std::size_t quantity) const;
    [[nodiscard]] std::optional<core::Sides> mean_half_widths(std::size_t quantity) const;
    [[nodiscard]] double numerical_half_width_m2() const;
    [[nodiscard]] std::optional<uncertainty::RegressedMean> regressed() const;
    [[nodiscard]] std::optional<uncertainty::MeanAtInput> at_friction(std::size_t quantity) const;
    [[nodiscard]] double mean_permeability() const;
    [[nodiscard]] double standard_error_m2() const;
    [[nodiscard]] Estimate estimate(std::size_t quantity) const;
    [[nodiscard]] results::SeedsQuantity quantity(std::size_t quantity) const;
    [[nodiscard]] results::MeasuredBed measured_bed() const;
    [[nodiscard]] results::UntilSure until_sure(bool out_of_time) const;

    const pouring::PackingConfig& packing_;
    const pouring::PackingsConfig& config_;
    std::vector<Member> members_;
    std::vector<double> pours_;
};

}  // namespace porepack::study
