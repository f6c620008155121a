#include "permeability/forchheimer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/error.hpp"

namespace porepack::permeability {
namespace {

struct Line {
    double intercept, slope;
};

// Least squares of y over x, with equal relative errors of y.
Line line_of_equal_relative_errors(std::span<const double> x, std::span<const double> y) {
    double w = 0.0, wx = 0.0, wy = 0.0, wxx = 0.0, wxy = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double weight = 1.0 / (y[i] * y[i]);
        w += weight;
        wx += weight * x[i];
        wy += weight * y[i];
        wxx += weight * x[i] * x[i];
        wxy += weight * x[i] * y[i];
    }
    const double slope = (w * wxy - wx * wy) / (w * wxx - wx * wx);
    return {(wy - slope * wx) / w, slope};
}

}  // namespace

ForchheimerFit fit_forchheimer(double permeability_m2, double length_m, std::span<const ApparentPermeability> flows,
                               double relative_error) {
    if (flows.size() < 3)
        throw NumericalError(fmt::format("{} steady flows with inertia are too few for the inertial permeability", flows.size()),
                             {.allowed = "three or more", .fix = "start at a smaller Reynolds number, or use smaller voxels"});
    std::size_t first = 0;
    while (first < flows.size() && flows[first].permeability_m2 > 0.95 * permeability_m2) ++first;
    ForchheimerFit fit{.permeability_m2 = permeability_m2, .largest_reynolds = flows.back().reynolds};
    if (first < flows.size()) {
        const double above = first > 0 ? flows[first - 1].permeability_m2 : permeability_m2, below = flows[first].permeability_m2,
                     wanted = 0.95 * permeability_m2;
        const double from = first > 0 ? flows[first - 1].reynolds : 0.0;
        fit.onset_reynolds = from + (flows[first].reynolds - from) * (above - wanted) / (above - below);
    }
    first = std::min(first, flows.size() - 3);
    std::vector<double> x, y;
    for (std::size_t i = first; i < flows.size(); ++i) {
        x.push_back(flows[i].reynolds / length_m);  // U/nu
        y.push_back(1.0 / flows[i].permeability_m2);
    }
    const std::size_t n = x.size();
    fit.points = n;
    const Line line = line_of_equal_relative_errors(x, y);
    // Slopes with the effect of the errors at their two ends: of the last two flows, through creeping flow, and of the whole straight part.
    const auto error_of = [&](std::size_t i) { return flows[first + i].relative_error * y[i]; };
    struct Slope {
        double value, error;
    };
    const std::array<Slope, 3> slopes = {
        {{(y[n - 1] - y[n - 2]) / (x[n - 1] - x[n - 2]), (error_of(n - 1) + error_of(n - 2)) / (x[n - 1] - x[n - 2])},
         {(y[n - 1] - 1.0 / permeability_m2) / x[n - 1], error_of(n - 1) / x[n - 1]},
         {line.slope, (error_of(n - 1) + error_of(0)) / (x[n - 1] - x[0])}}};
    double minimum = line.slope, low = line.slope, high = line.slope;
    for (const Slope& slope : slopes) {
        minimum = std::min(minimum, slope.value);
        low = std::min(low, slope.value - slope.error);
        high = std::max(high, slope.value + slope.error);
    }
    if (!(minimum > 0.0))
        throw NumericalError("the permeability does not fall with the Reynolds number: no inertial permeability",
                             {.fix = "reduce the tolerance, or use larger Reynolds numbers"});
    fit.intercept_permeability_m2 = 1.0 / line.intercept;
    fit.inertial_permeability_m = 1.0 / line.slope;
    fit.inertial_interval_m = {1.0 / (high * (1.0 + relative_error)), 1.0 / std::max(low * (1.0 - relative_error), 0.2 * minimum)};
    fit.extrapolated_interval_m = {fit.inertial_interval_m.low * (1.0 - turbulent_change),
                                   fit.inertial_interval_m.high / (1.0 - turbulent_change)};
    fit.inertial_factor = std::sqrt(permeability_m2) / fit.inertial_permeability_m;
    return fit;
}

std::optional<double> inertial_grid_error(const InertialCurve& coarse, const InertialCurve& fine, double length_m) {
    const std::size_t both = std::min(fine.flows.size(), coarse.flows.size());
    if (both < 3) return std::nullopt;
    const auto k_in = [&](const InertialCurve& curve) {
        return fit_forchheimer(curve.permeability_m2, length_m, std::span(curve.flows).first(both)).inertial_permeability_m;
    };
    return std::abs(k_in(fine) / k_in(coarse) - 1.0);
}

std::vector<double> pressure_drops(std::span<const double> reynolds, const InertialCurve& known, const ForchheimerFit& fit,
                                   double section_m, double length_m, double viscosity_m2_per_s) {
    const double nu = viscosity_m2_per_s;
    std::vector<double> drops = {nu * nu / length_m * 0.01 * section_m / fit.permeability_m2};
    for (std::size_t i = 0; i < reynolds.size(); ++i) {
        const ApparentPermeability& flow = known.flows[std::min(i, known.flows.size() - 1)];
        const double beyond = i < known.flows.size() ? 0.0 : (reynolds[i] - flow.reynolds) / length_m / fit.inertial_permeability_m;
        drops.push_back(nu * nu * reynolds[i] / length_m * section_m * (1.0 / flow.permeability_m2 + beyond));
    }
    return drops;
}

}  // namespace porepack::permeability
