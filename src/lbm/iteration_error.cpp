#include "lbm/iteration_error.hpp"
#include "lbm/uses.hpp"

#include <algorithm>
#include <cmath>

namespace porepack::lbm {
namespace {

double first_order_change(const ConvergencePoint& point) {
    return std::max(std::abs(point.expected_lu / point.permeability_lu - 1.0),
                    std::abs(point.expected_volume_lu / point.permeability_volume_lu - 1.0));
}

constexpr double slowest_ratio = 0.85;  // of successive changes: slow drifts decay with a power of the time, not exponentially

// Relative change that remains if the last two changes over `apart` checks continue geometrically. Alternating changes, which the first
// order contains, count with a fifth.
double remaining_change(const std::vector<ConvergencePoint>& history, double ConvergencePoint::*value, std::size_t apart) {
    const std::size_t last = history.size() - 1;
    const double now = history[last].*value, middle = history[last - apart].*value, first = history[last - 2 * apart].*value;
    const double change = now - middle, change_before = middle - first;
    if (change == 0.0) return 0.0;
    const double ratio = change_before == 0.0 ? slowest_ratio : std::min(slowest_ratio, std::abs(change / change_before));
    return std::abs(change / now) * (change * change_before < 0.0 ? 0.2 : ratio / (1.0 - ratio));
}

// What `value` has covered from the check `from` to the check `to`, both inclusive.
double range(const std::vector<ConvergencePoint>& history, double ConvergencePoint::*value, std::size_t from, std::size_t to) {
    double low = history[from].*value, high = low;
    for (std::size_t i = from + 1; i <= to; ++i) {
        low = std::min(low, history[i].*value);
        high = std::max(high, history[i].*value);
    }
    return high - low;
}

}  // namespace

// Eq. (T14).
Unsteadiness unsteadiness(const Drive& drive, const FlowSection& section, const Layers& before, const Layers& now, long steps, double force,
                          double gradient) {
    const auto first = static_cast<std::size_t>(section.first_layer), last = static_cast<std::size_t>(section.last_layer);
    // The reference of the density, half-way between the two states: the mean over the planes, or over a closed cell, where a uniform
    // drift then has no effect.
    double reference = 0.0;
    for (const Layers* state : {&before, &now})
        reference += drive.by_pressure() ? 0.25 * (density_on_plane(drive, *state, first) + density_on_plane(drive, *state, last + 1))
                                         : 0.5 * mean_density(state->nodes, state->density);
    double kinetic = 0.0, elastic = 0.0, flow = 0.0, plane = 0.0, sum = 0.0, planes = 0.0;
    for (std::size_t l = first; l <= last; ++l) {
        const double gain = now.nodes[l] * (now.density[l] - before.density[l]);
        kinetic += now.kinetic[l] - before.kinetic[l];
        elastic += now.elastic[l] - before.elastic[l] - reference / 3.0 * gain;
        flow += now.flow[l];
        const double here = plane - 0.5 * gain / static_cast<double>(steps);
        plane -= gain / static_cast<double>(steps);
        sum += here;
        if (l == first || l == last) planes += 0.5 * here;
    }
    if (first == last) planes = sum;
    const auto layers = static_cast<double>(last - first + 1);
    const double mean = flow / layers, energy = (kinetic - elastic) / (static_cast<double>(steps) * gradient * flow);
    if (!drive.by_pressure()) return {.energy = energy};
    // The pressure does its work on the flow rates of the planes, the force on the mean one.
    return {.energy = energy + (1.0 - force / gradient) * (0.5 * plane - sum / layers) / mean, .mass = (planes - sum / layers) / mean};
}

double iteration_error(const std::vector<ConvergencePoint>& history) {
    const std::size_t n = history.size();
    if (n < 3) return 1.0;
    double further = 0.0;
    for (const std::size_t apart : {std::max<std::size_t>(1, n / 5), std::max<std::size_t>(1, n / 3)})
        if (n > 2 * apart)
            for (const auto value : {&ConvergencePoint::expected_lu, &ConvergencePoint::expected_volume_lu})
                further = std::max(further, remaining_change(history, value, apart));
    // Eq. (T15).
    const double estimate = 1.5 * std::max(first_order_change(history[n - 1]), first_order_change(history[n - 2])) + 2.0 * further;
    return std::isfinite(estimate) ? std::min(1.0, estimate) : 1.0;
}

double iteration_error_with_inertia(const std::vector<ConvergencePoint>& history) {
    constexpr std::size_t min_checks = 12;
    constexpr double least = 0.5;  // of what the last checks have covered
    const std::size_t n = history.size();
    if (n < min_checks) return 1.0;
    double further = 0.0;
    for (const std::size_t apart : {n / 5, n / 3})
        for (const auto value : {&ConvergencePoint::permeability_lu, &ConvergencePoint::permeability_volume_lu}) {
            const double late = range(history, value, n - 1 - apart, n - 1),
                         before = range(history, value, n - 1 - 2 * apart, n - 1 - apart);
            const double ratio = before == 0.0 ? slowest_ratio : std::min(slowest_ratio, late / before);
            const double change = std::max(least, ratio / (1.0 - ratio)) * late / std::abs(history.back().*value);
            if (!std::isfinite(change)) return 1.0;
            further = std::max(further, change);
        }
    return std::min(1.0, 2.0 * further);
}

bool grows(const std::vector<ConvergencePoint>& history, double tolerance) {
    constexpr std::size_t parts = 4, min_checks = 20;  // of 40 steps
    constexpr double growth = 1.5;
    const std::size_t n = history.size(), checks = n / (2 * parts);
    if (n < min_checks) return false;
    double before = 0.0;
    for (std::size_t first = n - 1 - parts * checks; first + 1 < n; first += checks) {
        const double here = range(history, &ConvergencePoint::expected_lu, first, first + checks);
        if (!(here > growth * before)) return false;
        before = here;
    }
    return before > tolerance * std::abs(history.back().permeability_lu);
}

std::optional<double> share_of_steps(const std::vector<ConvergencePoint>& history, double tolerance) {
    // A straight line through the logarithms of the errors.
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t i = history.size() / 2; i < history.size(); ++i) {
        if (history[i].iteration_error >= 1.0 || history[i].iteration_error <= 0.0) continue;
        const double step = static_cast<double>(history[i].step), error = std::log(history[i].iteration_error);
        n += 1.0, x += step, y += error, xx += step * step, xy += step * error;
    }
    if (n < 3.0) return std::nullopt;
    const double slope = (n * xy - x * y) / (n * xx - x * x), now = static_cast<double>(history.back().step);
    if (!(slope * now < -0.05)) return std::nullopt;  // it does not fall
    const double end = x / n + (std::log(tolerance) - y / n) / slope, check = now - static_cast<double>(history[history.size() - 2].step);
    return now / (std::max(now, end) + check);  // two checks in succession meet the tolerance
}

}  // namespace porepack::lbm
