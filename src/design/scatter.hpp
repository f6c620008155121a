// The standard deviations between the packings of several beds, each known from two or three packings, and the intervals that follow.
#pragma once

#include <optional>
#include <vector>

namespace porepack::design {

/// Between the packings of one bed, in the quantity's unit or relative.
struct BedScatter {
    double deviation = 0.0;  ///< standard deviation, with packings - 1 degrees of freedom
    long packings = 1;
};

/// Beds do not scatter equally, and a few packings of one bed tell its scatter badly. The variances sigma^2 of the beds are taken to have
/// a scaled inverse chi-squared distribution of d0 degrees of freedom and scale s0^2 (Smyth 2004). The variance of a bed with s^2 of d =
/// n - 1 degrees of freedom is then estimated by (d0 s0^2 + d s^2) / (d0 + d), and the interval of its mean has t quantiles of d0 + d
/// degrees of freedom. A few beds do not tell d0 and s0 well either: the interval is that of the mean over all d0 and s0, weighted by how
/// likely they make the deviations of the beds (before the first bed, all ln s0 and all d0 / (d0 + 2) are equally likely). With one bed,
/// this is its own t interval; with many beds that scatter equally, it comes near that of the pooled deviation.
class ScatterOfBeds {
public:
    /// Beds of one packing tell nothing and are left out.
    explicit ScatterOfBeds(const std::vector<BedScatter>& beds);
    /// Half width of the 95 % interval of the mean of a bed's packings, two or more. The bed is one of those of the constructor; or one
    /// that is not poured yet, with a deviation that is expected.
    [[nodiscard]] double half_width(const BedScatter& bed) const;
    /// Probability that this mean is further than `distance` from the mean of all such packings.
    [[nodiscard]] double chance_beyond(const BedScatter& bed, double distance) const;
    /// Middle of the distribution of the deviations, s0; none where no bed has several packings.
    [[nodiscard]] std::optional<double> typical() const;
    /// Of the common s0^2 in the variance of a bed of three packings: 0 where beds differ much, 1 where they are equal.
    [[nodiscard]] std::optional<double> common_weight() const;

private:
    struct Node {
        double freedom, variance, weight;  // d0, s0^2; the weights' sum is 1
    };
    std::vector<Node> nodes_;  // none where no bed has several packings
};

}  // namespace porepack::design
