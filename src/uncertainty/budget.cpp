#include "uncertainty/budget.hpp"

#include <algorithm>
#include <cmath>

#include "permeability/permeability.hpp"

namespace porepack::uncertainty {

double between_methods(double value, const std::optional<Interval>& interval, double other_value,
                       const std::optional<Interval>& other_interval) {
    const double difference = value - other_value;
    const Sides one = half_widths(value, interval.value_or(Interval{value, value})),
                other = half_widths(other_value, other_interval.value_or(Interval{other_value, other_value}));
    const double facing = difference > 0.0 ? std::hypot(one.below, other.above) : std::hypot(one.above, other.below);
    const double own = facing / coverage_factor;
    return std::sqrt(std::max(0.0, 0.5 * (difference * difference - own * own))) / std::abs(value);
}

double permeability_change(double porosity, double change) {
    return permeability::kozeny_uncertainty(porosity, (1.0 - porosity) * std::abs(change));
}

}  // namespace porepack::uncertainty
