#include "permeability/budget.hpp"

#include <algorithm>
#include <cmath>

namespace porepack::permeability {

double between_methods(double value, double uncertainty, double other_value, double other_uncertainty) {
    const double difference = value - other_value;
    const double own = uncertainty * uncertainty + other_uncertainty * other_uncertainty;
    return std::sqrt(std::max(0.0, 0.5 * (difference * difference - own))) / std::abs(value);
}

double permeability_change(double porosity, double change) {
    return (3.0 / porosity + 2.0 / (1.0 - porosity)) * (1.0 - porosity) * std::abs(change);
}

}  // namespace porepack::permeability
