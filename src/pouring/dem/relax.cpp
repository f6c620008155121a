#include "pouring/dem/relax.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr double largest_overlap_of_diameter_here = 0.5;
constexpr long longest_push = 1000;  // contact times without weight
constexpr long part = 500;           // steps between two checks

struct Scale {
    ContactTimes times;
    double weight_overlap_m;  // of the heaviest grain's weight on one contact
    double rest_limit_J;
};

Scale scale_of(const Packing& packing, const PackingConfig& config) {
    double smallest = 1e300, largest = 0.0, sum = 0.0;
    std::vector<double> volumes;
    std::size_t at_once = 0;
    for (const Shape& shape : packing.shapes) at_once = std::max(at_once, contacts_at_once(shape));
    for (const Shape& shape : packing.shapes) volumes.push_back(measure(shape, 1e-4).volume_m3);
    for (const Body& body : packing.bodies) {
        smallest = std::min(smallest, volumes[body.shape]);
        largest = std::max(largest, volumes[body.shape]);
        sum += volumes[body.shape];
    }
    const double rho = config.density_kg_per_m3, g = config.gravity_m_per_s2, d = finest_diameter(packing);
    return {.times = contact_times(rho * smallest, rho * largest, d, at_once, config),
            .weight_overlap_m = rho * largest * g / (0.5 * config.normal_stiffness_N_per_m),
            .rest_limit_J = config.rest_energy_fraction * rho * sum / static_cast<double>(packing.bodies.size()) * g * d};
}

CapsuleDem dem_of(const Packing& packing, const PackingConfig& config, double time_step_s, double gravity_m_per_s2) {
    CapsuleDem dem(packing.container, packing.shapes, config.density_kg_per_m3, contact_law(config),
                   {.time_step_s = time_step_s, .gravity_m_per_s2 = Vec3(0, 0, -gravity_m_per_s2)});
    for (const Body& body : packing.bodies) dem.add(body.shape, body.position_m, body.orientation);
    return dem;
}

void require_small_overlaps(const Packing& packing) {
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing);
    const auto refuse = [&](const std::string& what, double overlap) {
        throw UserError(fmt::format("{} by {:.2g} of the thinnest capsule's diameter", what, overlap / d),
                        {.allowed = fmt::format("{:g}: beyond it the direction in which a grain should move is not defined",
                                                largest_overlap_of_diameter_here)});
    };
    if (overlaps.largest_between_grains_m > largest_overlap_of_diameter_here * d)
        refuse(fmt::format("grains {} and {} overlap", overlaps.grains[0], overlaps.grains[1]), overlaps.largest_between_grains_m);
    if (overlaps.largest_with_wall_m > largest_overlap_of_diameter_here * d)
        refuse(fmt::format("grain {} overlaps the wall", overlaps.grain_at_wall), overlaps.largest_with_wall_m);
}

double largest_overlap(const Packing& packing) {
    const Overlaps overlaps = find_overlaps(packing);
    return std::max(overlaps.largest_between_grains_m, overlaps.largest_with_wall_m);
}

// Contacts push, and what moves is stopped after each quarter of a contact time: no grain flies off.
Packing push_apart(const Packing& packing, const PackingConfig& config, const Scale& scale, long& steps) {
    CapsuleDem dem = dem_of(packing, config, scale.times.time_step_s, 0.0);
    const long burst = std::max(1L, std::lround(0.25 * scale.times.contact_time_s / scale.times.time_step_s));
    const double limit = 3.0 * scale.weight_overlap_m, before = largest_overlap(packing);
    Progress progress("relax (overlaps)");
    for (long n = 0; n < 4 * longest_push; ++n) {
        if (n % 20 == 0) {
            check_interrupt();
            const double overlap = largest_overlap(dem.packing());
            if (overlap <= limit) {
                steps += dem.steps();
                return dem.packing();
            }
            progress.update(std::clamp(std::log(before / overlap) / std::log(before / limit), 0.0, 0.99), fmt::format("{:.2g} m", overlap));
        }
        dem.step(burst);
        dem.stop();
    }
    throw NumericalError(
        fmt::format("the grains still overlap by {:.3g} m: they have no room", largest_overlap(dem.packing())),
        {.allowed = fmt::format("{:.3g} m", limit), .fix = "check the container's size, or fit the scan again with --image-fitted-sizes"});
}

std::vector<bool> standing_below(const Packing& packing) {
    std::vector<bool> held;
    for (const Body& body : packing.bodies) held.push_back(packing.container.cut_ends() && bounds_of(placed(packing, body)).low.z() < 0.0);
    return held;
}

}  // namespace

Relaxed relax(const Packing& packing, const PackingConfig& config) {
    if (packing.bodies.empty())
        throw UserError("there are no grains to relax", {.fix = "porepack pack --from FILE, with a packing.json that has bodies"});
    require_small_overlaps(packing);
    const Stopwatch watch;
    const Scale scale = scale_of(packing, config);
    constexpr double max_steps = 1e9;
    if (config.settle_time_s / scale.times.time_step_s > max_steps)
        throw UserError(
            fmt::format("the time step {:.3g} s is too short: {:g} s would need {:.2g} steps", scale.times.time_step_s,
                        config.settle_time_s, config.settle_time_s / scale.times.time_step_s),
            {.allowed = "1e9 steps", .fix = "check the grains' size and density; leave time_step_s out, or lower settle_time_s"});
    Relaxed found{.packing = push_apart(packing, config, scale, found.steps), .held = standing_below(packing)};
    found.overlap_before_m = find_overlaps(packing).largest_between_grains_m;

    CapsuleDem dem = dem_of(found.packing, config, scale.times.time_step_s, config.gravity_m_per_s2);
    for (std::size_t i = 0; i < dem.size(); ++i)
        if (found.held[i]) dem.hold(i);
    Progress progress("relax (rest)");
    for (DemRest rest = dem.rest();; rest = dem.rest()) {
        const bool at_rest = rest.kinetic_energy_per_grain_J < scale.rest_limit_J && rest.mean_force_over_weight < rest_force_limit;
        found.mean_force_over_weight = rest.mean_force_over_weight;
        found.kinetic_energy_per_grain_J = rest.kinetic_energy_per_grain_J;
        if (dem.steps() > 0 && at_rest) break;
        if (dem.time_s() > config.settle_time_s)
            throw NumericalError(
                fmt::format("the grains are not at rest after {:g} s: kinetic energy {:.3g} J per grain (limit {:.3g} J), net "
                            "force {:.2g} weights (limit {:g})",
                            config.settle_time_s, rest.kinetic_energy_per_grain_J, scale.rest_limit_J, rest.mean_force_over_weight,
                            rest_force_limit),
                {.fix = "raise settle_time_s; grains that the packing lacks let others fall"});
        dem.step(part);
        check_interrupt();
        progress.update(std::nullopt, fmt::format("{:.2f} s", dem.time_s()));
    }
    found.packing = dem.packing();
    found.steps += dem.steps();
    found.overlap_after_m = find_overlaps(found.packing).largest_between_grains_m;
    for (std::size_t i = 0; i < dem.size(); ++i) {
        const Body &from = packing.bodies[i], &to = found.packing.bodies[i];
        const Vec3 centre = dem.grain(from.shape).centre_m;
        Vec3 step = to.position_m + to.orientation * centre - from.position_m - from.orientation * centre;
        for (int axis = 0; axis < 3; ++axis)
            if (packing.container.periodic()[static_cast<std::size_t>(axis)])
                step[axis] -= packing.container.size()[axis] * std::round(step[axis] / packing.container.size()[axis]);
        found.moved_m.push_back(step.norm());
        found.turned_rad.push_back(from.orientation.angularDistance(to.orientation));
    }
    found.wall_time_s = watch.seconds();
    return found;
}

}  // namespace porepack::pouring::dem
