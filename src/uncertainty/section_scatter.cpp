#include "uncertainty/section_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "uncertainty/sample.hpp"

namespace porepack::uncertainty {
using core::Interval;
namespace {

constexpr double independent_diameters = 1.0, diameters_per_degree = 2.5;

double variogram(std::span<const double> values, std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < values.size(); ++i) sum += std::pow(values[i] - values[i - lag], 2.0);
    return 0.5 * sum / static_cast<double>(values.size() - lag);
}

struct Variances {
    double of_layer, of_mean;
};

std::optional<Variances> variances_of(std::span<const double> values, double section_m, double diameter_m, double farthest_diameters,
                                      double shortest_section_diameters) {
    const double diameters = section_m / diameter_m, layers = static_cast<double>(values.size()), per_diameter = layers / diameters;
    if (!(diameter_m > 0.0) || diameters < shortest_section_diameters || per_diameter < 4.0) return std::nullopt;
    const auto independent = static_cast<std::size_t>(std::lround(independent_diameters * per_diameter)),
               farthest = static_cast<std::size_t>(std::lround(farthest_diameters * per_diameter));
    double variance = 0.0;
    for (std::size_t lag = independent; lag < farthest; ++lag)
        variance += variogram(values, lag) / static_cast<double>(farthest - independent);
    double of_mean = variance;
    for (std::size_t lag = 1; lag < independent; ++lag)
        of_mean += 2.0 * (1.0 - static_cast<double>(lag) / layers) * (variance - variogram(values, lag));
    return Variances{.of_layer = variance, .of_mean = std::max(of_mean, 0.0) / layers};  // by chance the sum can be negative
}

}  // namespace

std::optional<SectionScatter> section_scatter(std::span<const double> gradient, double section_m, double diameter_m) {
    const auto variances = variances_of(gradient, section_m, diameter_m, 2.5, 3.5);
    if (!variances) return std::nullopt;
    const double diameters = section_m / diameter_m, relative = std::sqrt(variances->of_mean);
    return SectionScatter{.relative = relative,
                          .interval = interval_of_deviation(relative, std::max(1.0, diameters / diameters_per_degree)),
                          .section_m = section_m,
                          .diameters = diameters};
}

std::optional<PorosityScatter> porosity_scatter(std::span<const double> layer_porosity, double section_m, double diameter_m) {
    // In units of the deviation that independent layers of one diameter would cause: where it lies in beds (docs/pores.md), and the same
    // with the error of that deviation in a single section.
    constexpr Interval beds = {0.35, 0.7}, single = {0.2, 1.25};
    const auto variances = variances_of(layer_porosity, section_m, diameter_m, 2.0, 2.5);
    if (!variances) return std::nullopt;
    const double independent = std::sqrt(variances->of_layer * diameter_m / section_m);
    return PorosityScatter{.deviation = std::clamp(std::sqrt(variances->of_mean), beds.low * independent, beds.high * independent),
                           .interval = {single.low * independent, single.high * independent}};
}

}  // namespace porepack::uncertainty
