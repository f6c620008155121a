#include "permeability/pressure_drop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.hpp"

namespace porepack::permeability {

namespace {

struct Excess {
    double value = 0.0, error = 0.0;  ///< of k / k_apparent - 1
};

Excess excess_at(const InertialCurve& curve, double reynolds) {
    const auto& flows = curve.flows;
    const auto excess = [&](const ApparentPermeability& flow) { return curve.permeability_m2 / flow.permeability_m2 - 1.0; };
    const auto own_error = [&](const ApparentPermeability& flow) { return 2.0 * flow.relative_error * (1.0 + excess(flow)); };
    const auto after =
        std::find_if(flows.begin(), flows.end(), [&](const ApparentPermeability& flow) { return flow.reynolds >= reynolds; });
    if (after == flows.begin()) {
        const double part = reynolds / after->reynolds, linear = part * excess(*after), quadratic = part * linear;
        return {0.5 * (linear + quadratic), 0.5 * std::abs(linear - quadratic) + part * own_error(*after)};
    }
    const auto before = std::prev(after);
    const double low = excess(*before), high = excess(*after);
    const double linear = low + (high - low) * (reynolds - before->reynolds) / (after->reynolds - before->reynolds);
    const double error = std::max(own_error(*before), own_error(*after));
    if (!(low > 0.0 && high > 0.0)) return {linear, error};
    const double power = low * std::pow(high / low, std::log(reynolds / before->reynolds) / std::log(after->reynolds / before->reynolds));
    return {power, std::abs(power - linear) + error};
}

double modified_reynolds(double velocity, const Fluid& fluid, double diameter_m, double porosity) {
    return fluid.density_kg_per_m3 * velocity * diameter_m / (fluid.viscosity_Pa_s * (1.0 - porosity));
}

// mu U (1 - eps)^2 / (d^2 eps^3)
double viscous_unit(double velocity, const Fluid& fluid, double diameter_m, double porosity) {
    const double solid = 1.0 - porosity;
    return fluid.viscosity_Pa_s * velocity * solid * solid / (diameter_m * diameter_m * std::pow(porosity, 3));
}

}  // namespace

InertialFactor inertial_factor(const InertialCurve& fine, const std::optional<InertialCurve>& coarse, double reynolds) {
    const double largest = fine.flows.empty() ? 0.0 : fine.flows.back().reynolds;
    // The same Reynolds number, given in other words, may differ in its last digits.
    if (reynolds > largest * (1.0 + 1e-6))
        throw UserError(fmt::format("no flow was computed at a Reynolds number of {:.4g}", reynolds),
                        {.allowed = fmt::format("up to {:.4g}", largest)});
    const Excess found = excess_at(fine, std::min(reynolds, largest));
    InertialFactor factor{.value = 1.0 + found.value, .half_width = found.error / (1.0 + found.value)};
    if (coarse && !coarse->flows.empty()) {
        const double both = std::min({reynolds, largest, coarse->flows.back().reynolds}), here = excess_at(fine, both).value;
        const double change = (1.0 + excess_at(*coarse, both).value) / (1.0 + here) - 1.0;
        // Beyond the last flow of the coarser grid, the change grows like the inertia, at least in proportion to Re.
        const double growth = std::max(reynolds / both, here > 0.0 ? found.value / here : 0.0);
        factor.half_width = std::hypot(factor.half_width, change * growth);
    }
    return factor;
}

InertialFactor creeping_factor(double superficial_velocity_m_per_s, double permeability_m2, double viscosity_m2_per_s) {
    constexpr double ward = 0.55;
    return {.value = 1.0, .half_width = ward * superficial_velocity_m_per_s * std::sqrt(permeability_m2) / viscosity_m2_per_s};
}

PressureGradient pressure_gradient(double superficial_velocity_m_per_s, const Fluid& fluid, double permeability_m2,
                                   const Interval& permeability_interval_m2, const InertialFactor& factor) {
    const double value = fluid.viscosity_Pa_s * superficial_velocity_m_per_s / permeability_m2 * factor.value;
    const double below = std::hypot(1.0 - permeability_m2 / permeability_interval_m2.high, factor.half_width),
                 above = std::hypot(permeability_m2 / permeability_interval_m2.low - 1.0, factor.half_width);
    return {value, {value * (1.0 - below), value * (1.0 + above)}};
}

double erdim_gradient(double superficial_velocity_m_per_s, const Fluid& fluid, double diameter_m, double porosity) {
    const double re = modified_reynolds(superficial_velocity_m_per_s, fluid, diameter_m, porosity);
    return (160.0 + 2.81 * std::pow(re, 0.904)) * viscous_unit(superficial_velocity_m_per_s, fluid, diameter_m, porosity);
}

double ergun_gradient(double superficial_velocity_m_per_s, const Fluid& fluid, double diameter_m, double porosity) {
    const double re = modified_reynolds(superficial_velocity_m_per_s, fluid, diameter_m, porosity);
    return (150.0 + 1.75 * re) * viscous_unit(superficial_velocity_m_per_s, fluid, diameter_m, porosity);
}

}  // namespace porepack::permeability
