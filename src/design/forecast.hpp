// What the beds that are known tell of each grain that could be chosen, and which one to pour next.
#pragma once

#include <optional>
#include <vector>

#include "design/bed.hpp"
#include "design/design.hpp"

namespace porepack::design {

/// Relative scatter of k and scatter of porosity from packing to packing where no bed is known.
constexpr double scatter_without_data = 0.12, porosity_scatter_without_data = 0.01;

class Forecaster {
public:
    /// `goal` and `bed` must outlive it. Throws UserError where no grain meets the goal's limits.
    Forecaster(const DesignGoal& goal, const DesignBed& bed, std::vector<KnownBed> known);

    void learn(const KnownBed& bed) { known_.push_back(bed); }
    [[nodiscard]] const std::vector<KnownBed>& known() const { return known_; }

    /// Of the mean of the packings of a proposal that is not poured yet, 95 %, without the numerical part.
    struct HalfWidths {
        double permeability, porosity;
    };
    [[nodiscard]] HalfWidths expected_half_widths() const;
    /// Each grain that is allowed, in the size that gives the wanted k if the volume is free.
    [[nodiscard]] std::vector<SizedCandidate> forecasts(const std::vector<Proposal>& computed) const;

private:
    [[nodiscard]] std::optional<Prediction> own_prediction(const Candidate& grain, double wall,
                                                           const std::vector<Proposal>& computed) const;
    [[nodiscard]] SizedCandidate forecast(const Candidate& candidate, double size_m, const Prediction& prediction,
                                          const HalfWidths& expected) const;
    [[nodiscard]] bool allowed(const SizedCandidate& one) const;

    const DesignGoal& goal_;
    const DesignBed& bed_;
    std::vector<KnownBed> known_;
    std::vector<Candidate> candidates_;
};

/// The most promising grain that has not been tried; where no chance is left, the nearest.
[[nodiscard]] std::optional<SizedCandidate> best(const std::vector<SizedCandidate>& all, const std::vector<Proposal>& computed);

[[nodiscard]] bool same_grain(const Candidate& one, const Candidate& other);
/// Two poured beds that are as wide, in grains.
[[nodiscard]] bool same_bed(double wall, double other);

}  // namespace porepack::design
