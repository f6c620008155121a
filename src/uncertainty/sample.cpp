#include "uncertainty/sample.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace porepack::uncertainty {
namespace {

constexpr double upper_quantile = 0.975;  // of an interval of 95 %

double after_looks(double deviation, double packings) {
    return students_t(packings - 1.0) * deviation / std::sqrt(packings) * (1.0 + 2.0 / packings);
}

}  // namespace

Sample sample_of(std::span<const double> values) {
    Sample sample{.packings = values.size()};
    const auto n = static_cast<double>(values.size());
    for (const double value : values) sample.mean += value / n;
    double squares = 0.0;
    for (const double value : values) squares += (value - sample.mean) * (value - sample.mean);
    if (values.size() > 1) sample.deviation = std::sqrt(squares / (n - 1.0));
    return sample;
}

double students_t(double degrees_of_freedom) {
    return boost::math::quantile(boost::math::students_t(degrees_of_freedom), upper_quantile);
}

std::optional<Interval> interval_of_mean(const Sample& sample, const Sides& numerical, StudyEnd end) {
    if (sample.packings < 2) return std::nullopt;
    const auto n = static_cast<double>(sample.packings);
    const double scatter =
        end == StudyEnd::when_sure ? half_width_after_looks(sample) : students_t(n - 1.0) * sample.deviation / std::sqrt(n);
    return about(sample.mean, in_quadrature({scatter, scatter}, numerical));
}

std::optional<Interval> interval_of_next(const Sample& sample, const Sides& numerical, StudyEnd end) {
    if (sample.packings < 2) return std::nullopt;
    const auto n = static_cast<double>(sample.packings);
    const double early = end == StudyEnd::when_sure ? 1.0 + 1.0 / n : 1.0;
    const double scatter = early * students_t(n - 1.0) * sample.deviation * std::sqrt(1.0 + 1.0 / n);
    return about(sample.mean, in_quadrature({scatter, scatter}, numerical));
}

Interval interval_of_deviation(double deviation, double degrees_of_freedom) {
    const boost::math::chi_squared squares(degrees_of_freedom);
    return {deviation * std::sqrt(degrees_of_freedom / boost::math::quantile(squares, upper_quantile)),
            deviation * std::sqrt(degrees_of_freedom / boost::math::quantile(squares, 1.0 - upper_quantile))};
}

double half_width_after_looks(const Sample& sample) {
    if (sample.packings < 2) return std::numeric_limits<double>::infinity();
    return after_looks(sample.deviation, static_cast<double>(sample.packings));
}

double relative_half_width(const Sample& sample, double numerical_half_width) {
    return std::hypot(half_width_after_looks(sample), numerical_half_width) / sample.mean;
}

double unseen_share(std::size_t packings) {
    return 1.0 - std::pow(0.05, 1.0 / static_cast<double>(packings));
}

std::optional<std::size_t> packings_for(double relative_deviation, double relative_half_width, double numerical_half_width) {
    if (numerical_half_width >= relative_half_width) return std::nullopt;
    const double wanted = std::sqrt(relative_half_width * relative_half_width - numerical_half_width * numerical_half_width);
    std::size_t packings = min_packings;
    while (after_looks(relative_deviation, static_cast<double>(packings)) > wanted) packings += 1 + packings / 100;
    return packings;
}

}  // namespace porepack::uncertainty
