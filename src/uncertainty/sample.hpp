// What several packings of one case tell about their mean and about the next packing.
#pragma once

#include <optional>
#include <span>

#include "core/interval.hpp"
#include "core/sides.hpp"

namespace porepack::uncertainty {

/// Of independent packings.
struct Sample {
    std::size_t packings = 0;
    double mean = 0.0;
    double deviation = 0.0;  ///< standard deviation of one packing, with n - 1 degrees of freedom; 0 for one packing
    [[nodiscard]] double relative_deviation() const { return deviation / mean; }
};
[[nodiscard]] Sample sample_of(std::span<const double> values);

/// Two-sided 95 % quantile of Student's t.
[[nodiscard]] double students_t(double degrees_of_freedom);

/// What ended a study: a number of packings that was fixed before, or an interval that had become narrow enough.
enum class StudyEnd { at_number, when_sure };

/// 95 % confidence interval of the mean of such packings, t s / sqrt(n) (when_sure: see half_width_after_looks()). `numerical` are the half
/// widths of one packing's value. They are the same for all of them, do not shrink with n, and are added in quadrature, each on its side.
/// None for fewer than two packings.
[[nodiscard]] std::optional<core::Interval> interval_of_mean(const Sample& sample, const core::Sides& numerical,
                                                             StudyEnd end = StudyEnd::at_number);
/// 95 % prediction interval of one more such packing, t s sqrt(1 + 1/n); when_sure: times 1 + 1/n, because s is small by chance where a
/// study ends early.
[[nodiscard]] std::optional<core::Interval> interval_of_next(const Sample& sample, const core::Sides& numerical,
                                                             StudyEnd end = StudyEnd::at_number);
/// 95 % confidence interval of the standard deviation of normal values, from chi squared.
[[nodiscard]] core::Interval interval_of_deviation(double deviation, double degrees_of_freedom);

/// The rule by which a study ends that looks at its interval after every packing. A plain t interval of a study that ends as soon as the
/// interval is narrow covers the mean in only 92 to 95 %, because it ends early where the scatter seems small by chance. The half width
/// is therefore t s / sqrt(n) (1 + 2/n): it covers the mean in at least 94 % of normal and log-normal packings, and in less where a few
/// packings differ much from all others (`porepack_benchmark stopping`).
inline constexpr std::size_t min_packings = 5;
[[nodiscard]] double half_width_after_looks(const Sample& sample);  ///< infinite for one packing
/// Relative half width of the mean after repeated looks, the numerical part (its wider side) included.
[[nodiscard]] double relative_half_width(const Sample& sample, double numerical_half_width);

/// Largest share of all such packings that n of them miss altogether with a probability of 5 %: 1 - 0.05^(1/n). Where packings of such a
/// share differ much from the others, no interval from n packings knows of it.
[[nodiscard]] double unseen_share(std::size_t packings);

/// Number of packings after which this rule is expected to end, for a relative scatter and relative half widths of mean and numerics;
/// none if the numerical part alone is larger.
[[nodiscard]] std::optional<std::size_t> packings_for(double relative_deviation, double relative_half_width,
                                                      double numerical_half_width = 0.0);

}  // namespace porepack::uncertainty
