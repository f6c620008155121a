// What the porosity of packings tells of their permeability: k of a bed of known porosity, and the mean k of many pours of which few have a
// computed flow.
#pragma once

#include <optional>
#include <span>

#include "core/interval.hpp"
#include "core/sides.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::uncertainty {

/// Least squares line y = mean_y + slope (x - mean_x).
struct Line {
    std::size_t points = 0;
    double mean_x = 0.0, mean_y = 0.0, slope = 0.0;
    double squares_x = 0.0;           ///< sum of (x - mean_x)^2
    double residual_deviation = 0.0;  ///< standard deviation about the line, with points - 2 degrees of freedom
    [[nodiscard]] double at(double x) const { return mean_y + slope * (x - mean_x); }
    /// Of the line at x, in units of the variance about it.
    [[nodiscard]] double relative_variance_at(double x) const;
    [[nodiscard]] double degrees_of_freedom() const { return static_cast<double>(points) - 2.0; }
};
/// None for fewer than three points, or where all x are the same.
[[nodiscard]] std::optional<Line> fit_line(std::span<const double> x, std::span<const double> y);

/// k of one more packing, from the line of ln k on the logarithm of the Kozeny function of its porosity. The interval (95 %) holds the
/// scatter about the line and the error of the line (Student's t), and the uncertainty of the porosity; `numerical` are the relative half
/// widths of one packing's k. They are added in quadrature.
struct BedEstimate {
    double permeability_m2 = 0.0;
    core::Interval interval_m2;
};
[[nodiscard]] BedEstimate bed_of_porosity(const Line& line, double porosity, double standard_uncertainty, const core::Sides& numerical);

/// The mean k of all pours, by double sampling: the line of k on the Kozeny function, from the packings whose flow is known (the first of
/// the pours), at the mean of that function over all pours.
struct RegressedMean {
    Line line;
    Sample pours;  ///< of the Kozeny function
    [[nodiscard]] double mean() const { return line.at(pours.mean); }
    /// Of one packing's k: about the line, and along it.
    [[nodiscard]] double deviation() const;
    /// Half width (95 %) of the mean after repeated looks: t s sqrt(1/n + ...) (1 + 2/n) about the line, in quadrature with 1.96 |slope| s
    /// / sqrt(pours) along it (see half_width_after_looks(); coverage: `porepack_benchmark stopping`).
    [[nodiscard]] double half_width() const;
    [[nodiscard]] core::Interval interval_of_mean(const core::Sides& numerical) const;
    [[nodiscard]] core::Interval interval_of_next(const core::Sides& numerical) const;
};
/// The mean at the given value of an input of standard uncertainty `input_uncertainty` (friction), from packings between which the input
/// varies: the line at that value. Its intervals (95 %) also hold the effect of the input, which does not shrink with the number of
/// packings.
struct MeanAtInput {
    Line line;
    double input = 0.0, input_uncertainty = 0.0;
    [[nodiscard]] double mean() const { return line.at(input); }
    [[nodiscard]] double effect() const;  ///< standard uncertainty of the mean by the input
    [[nodiscard]] core::Interval interval_of_mean(const core::Sides& numerical) const;
    [[nodiscard]] core::Interval interval_of_next(const core::Sides& numerical) const;
};

/// Flows that the first look needs: their line has as many degrees of freedom as the mean of min_packings.
inline constexpr std::size_t min_flows = min_packings + 1;

/// Number of flows after which half_width() is expected to be `half_width`, with `pours_per_flow` pours each; deviations about the line and
/// along it.
[[nodiscard]] std::size_t flows_for(double about_line, double along_line, double half_width, std::size_t pours_per_flow);

}  // namespace porepack::uncertainty
