#include "uncertainty/regression.hpp"

#include <cmath>

#include "permeability/permeability.hpp"
#include "uncertainty/budget.hpp"

namespace porepack::uncertainty {
namespace {

double after_looks(std::size_t flows) {
    const auto n = static_cast<double>(flows);
    return students_t(n - 2.0) * (1.0 + 2.0 / n);
}

}  // namespace

double Line::relative_variance_at(double x) const {
    return 1.0 / static_cast<double>(points) + (x - mean_x) * (x - mean_x) / squares_x;
}

std::optional<Line> fit_line(std::span<const double> x, std::span<const double> y) {
    if (x.size() < 3) return std::nullopt;
    Line line{.points = x.size(), .mean_x = sample_of(x).mean, .mean_y = sample_of(y).mean};
    double products = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        line.squares_x += (x[i] - line.mean_x) * (x[i] - line.mean_x);
        products += (x[i] - line.mean_x) * (y[i] - line.mean_y);
    }
    if (!(line.squares_x > 0.0)) return std::nullopt;
    line.slope = products / line.squares_x;
    double squares = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) squares += std::pow(y[i] - line.at(x[i]), 2.0);
    line.residual_deviation = std::sqrt(squares / line.degrees_of_freedom());
    return line;
}

BedEstimate bed_of_porosity(const Line& line, double porosity, double standard_uncertainty, const Sides& numerical) {
    const double x = std::log(permeability::kozeny_function(porosity)), k = std::exp(line.at(x)),
                 scatter = students_t(line.degrees_of_freedom()) * line.residual_deviation * std::sqrt(1.0 + line.relative_variance_at(x)),
                 of_porosity = coverage_factor * std::abs(line.slope) * permeability::kozeny_uncertainty(porosity, standard_uncertainty),
                 half = std::hypot(scatter, of_porosity);  // of ln k
    return {k, widened({k * std::exp(-half), k * std::exp(half)}, k, k * numerical)};
}

double RegressedMean::deviation() const {
    return std::hypot(line.residual_deviation, line.slope * pours.deviation);
}

double RegressedMean::half_width() const {
    const double about_line = after_looks(line.points) * line.residual_deviation * std::sqrt(line.relative_variance_at(pours.mean)),
                 along_line = coverage_factor * line.slope * pours.deviation / std::sqrt(static_cast<double>(pours.packings));
    return std::hypot(about_line, along_line);
}

Interval RegressedMean::interval_of_mean(const Sides& numerical) const {
    const double half = half_width();
    return about(mean(), in_quadrature({half, half}, numerical));
}

Interval RegressedMean::interval_of_next(const Sides& numerical) const {
    // About the line with few degrees of freedom, along it with many.
    const double one = std::hypot(students_t(line.degrees_of_freedom()) * line.residual_deviation,
                                  students_t(static_cast<double>(pours.packings) - 1.0) * line.slope * pours.deviation),
                 half = std::hypot(one, half_width());
    return about(mean(), in_quadrature({half, half}, numerical));
}

double MeanAtInput::effect() const {
    return std::abs(line.slope) * input_uncertainty;
}

namespace {

Interval interval_at_input(const MeanAtInput& found, double own_variance, const Sides& numerical) {
    const double scatter = students_t(found.line.degrees_of_freedom()) * found.line.residual_deviation *
                           std::sqrt(own_variance + found.line.relative_variance_at(found.input)),
                 half = std::hypot(scatter, coverage_factor * found.effect());
    return about(found.mean(), in_quadrature({half, half}, numerical));
}

}  // namespace

Interval MeanAtInput::interval_of_mean(const Sides& numerical) const {
    return interval_at_input(*this, 0.0, numerical);
}

Interval MeanAtInput::interval_of_next(const Sides& numerical) const {
    return interval_at_input(*this, 1.0, numerical);
}

std::size_t flows_for(double about_line, double along_line, double half_width, std::size_t pours_per_flow) {
    std::size_t flows = min_flows;
    const auto reached = [&] {
        const auto n = static_cast<double>(flows);
        return std::hypot(after_looks(flows) * about_line / std::sqrt(n),
                          coverage_factor * along_line / std::sqrt(n * static_cast<double>(pours_per_flow)));
    };
    while (reached() > half_width) flows += 1 + flows / 100;
    return flows;
}

}  // namespace porepack::uncertainty
