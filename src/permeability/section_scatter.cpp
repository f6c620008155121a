#include "permeability/section_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "permeability/sample.hpp"

namespace porepack::permeability {
namespace {

constexpr double independent_diameters = 1.0, farthest_diameters = 2.5, shortest_section_diameters = 3.5, diameters_per_degree = 2.5;

double variogram(std::span<const double> values, std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < values.size(); ++i) sum += std::pow(values[i] - values[i - lag], 2.0);
    return 0.5 * sum / static_cast<double>(values.size() - lag);
}

}  // namespace

std::optional<SectionScatter> section_scatter(std::span<const double> gradient, double section_m, double diameter_m) {
    const double diameters = section_m / diameter_m, layers = static_cast<double>(gradient.size()), per_diameter = layers / diameters;
    if (!(diameter_m > 0.0) || diameters < shortest_section_diameters || per_diameter < 4.0) return std::nullopt;
    const auto independent = static_cast<std::size_t>(std::lround(independent_diameters * per_diameter)),
               farthest = static_cast<std::size_t>(std::lround(farthest_diameters * per_diameter));
    double variance = 0.0;
    for (std::size_t lag = independent; lag < farthest; ++lag)
        variance += variogram(gradient, lag) / static_cast<double>(farthest - independent);
    double of_mean = variance;
    for (std::size_t lag = 1; lag < independent; ++lag)
        of_mean += 2.0 * (1.0 - static_cast<double>(lag) / layers) * (variance - variogram(gradient, lag));
    const double relative = std::sqrt(std::max(of_mean, 0.0) / layers);  // by chance the sum can be negative
    return SectionScatter{.relative = relative,
                          .interval = interval_of_deviation(relative, std::max(1.0, diameters / diameters_per_degree)),
                          .section_m = section_m,
                          .diameters = diameters};
}

}  // namespace porepack::permeability
