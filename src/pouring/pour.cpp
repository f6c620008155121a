#include "pouring/pour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "pouring/batches.hpp"
#include "pouring/uses.hpp"
#include "record/digest.hpp"
#include "record/resolved_config.hpp"

namespace porepack::pouring {
namespace {

// Eq. (T4), of two grains of this mass.
double contact_time(double mass, const PackingConfig& config) {
    const double kn = config.normal_stiffness_N_per_m / 2.0;
    // Near critical damping the contact time goes to infinity, but the forces change as fast as without damping.
    const double damped = std::max(0.7, 1.0 - config.normal_damping * config.normal_damping);
    return std::numbers::pi / std::sqrt(kn / (mass / 2.0) * damped);
}

// Approximate number of grains of this extent side by side.
double grains_per_batch(double extent, const Container& container) {
    return 1.5 * container.inner_area_m2() / (extent * extent);
}

// Into how many pieces the engine divides corners, edges, rims and axes of a grain with faces, roughly.
double expected_pieces(const RoundedBody& body) {
    const std::map<ContactCurve::Kind, double> of_curve = {{ContactCurve::Kind::corner, 1.0},
                                                           {ContactCurve::Kind::edge, 3.0},
                                                           {ContactCurve::Kind::rim, 8.0},
                                                           {ContactCurve::Kind::axis, 4.0}};
    double pieces = 0.0;
    for (const ContactCurve& curve : body.contact_curves()) pieces += of_curve.at(curve.kind);
    return pieces;
}

// Roughly: 0.2 s until a bed is at rest after a tap or under a lid; a box shrinks to a third of its width.
double expected_steps_of(const ProtocolConfig& protocol, const Container& container, const PackingConfig& config, double time_step_s) {
    constexpr double rest_s = 0.2;
    double time = 0.0;
    for (const ProtocolStep& step : protocol.step) {
        const double number = static_cast<double>(std::max(1L, step.number)),
                     period = step.frequency_Hz > 0.0 ? 1.0 / step.frequency_Hz : 0.0;
        const double fall = std::sqrt(8.0 * step.height_m / config.gravity_m_per_s2);
        time += number * (rest_s + fall) + (step.kind == StepKind::vibrate ? step.time_s : number * period);
        if (step.speed_m_per_s > 0.0) time += 0.3 * container.height() / step.speed_m_per_s;
    }
    return time / time_step_s;
}

// `expected_grains` are those of a bed that is filled to its height.
void add_expected_cost(PourPlan& plan, const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                       const ProtocolConfig& protocol, double expected_grains) {
    // From measurements: LIGGGHTS 0.4 us per sphere and step, with 0.6 of the grains present on average; capsules 0.1 us per capsule and
    // step, with 0.4 of the grains present and awake (0.25 to 0.55 in pours of 1152 to 2385 grains, docs/packing.md).
    const double grains = config.grains > 0 ? static_cast<double>(config.grains) : expected_grains;
    const double batch =
        std::min(static_cast<double>(config.batch_grains), std::max(1.0, grains_per_batch(maximum_feret_diameter(shapes), container)));
    const double fall = std::sqrt(2.0 * container.height() / config.gravity_m_per_s2);
    const double steps = ((config.fill == Fill::lattice ? 1.0 : grains / batch) * config.batch_interval_s + fall + 0.5) / plan.time_step_s;
    plan.expected_steps = steps;
    if (steps > 1e9)
        throw UserError(fmt::format("the time step {:.3g} s is too short: the pour would need {:.2g} steps", plan.time_step_s, steps),
                        {.allowed = "1e9 steps", .fix = "leave time_step_s out: it is then chosen from the contact time"});
    plan.expected_protocol_steps = expected_steps_of(protocol, container, config, plan.time_step_s);
    if (config.engine == Engine::liggghts) {
        plan.expected_wall_time_s = 0.4e-6 * grains * static_cast<double>(plan.clump_spheres) *
                                    (0.6 * steps + plan.expected_protocol_steps) / static_cast<double>(config.processes);
        plan.expected_memory_bytes = 60e6 + 4000.0 * static_cast<double>(plan.max_grains * plan.clump_spheres);
    } else {
        constexpr double per_capsule_s = 0.1e-6, per_piece_s = 0.25e-6;  // the latter from pours of 36 to 1000 cylinders and rings
        double arms = 0.0, step_s = 0.0;
        for (const auto& [shape, share] : shapes) {
            const double count = shape.body != nullptr ? expected_pieces(*shape.body) : static_cast<double>(shape.capsules.size());
            arms += share * count;
            step_s += share * count * (shape.body != nullptr ? per_piece_s : per_capsule_s);
        }
        constexpr double min_step_for_threads_s = 0.1e-3, gain_of_a_thread = 0.6, max_threads = 4.0;
        const double step_of_all_s = step_s * 0.4 * grains;
        const double threads = step_of_all_s < min_step_for_threads_s ? 1.0 : std::min(max_threads, static_cast<double>(thread_count()));
        // During a protocol all grains are present, and awake.
        const double all_awake = step_s * grains * plan.expected_protocol_steps;
        plan.expected_wall_time_s = (step_of_all_s * steps + all_awake) / (1.0 + gain_of_a_thread * (threads - 1.0));
        plan.expected_memory_bytes = 20e6 + grains * (2000.0 + 4000.0 * arms);
    }
}

}  // namespace

// The potential of two flat faces is up to 3 times as stiff as that of a corner on a face: of 45 sqrt(12 / 6) steps for the contact of a
// corner, 37 are left.
std::size_t contacts_at_once(const Shape& shape) {
    constexpr std::size_t of_faces = 12;
    return shape.body != nullptr ? of_faces : shape.capsules.size();
}

ContactTimes contact_times(double lightest_kg, double heaviest_kg, double diameter_m, std::size_t at_once, const PackingConfig& config) {
    const double static_overlap = heaviest_kg * config.gravity_m_per_s2 / (config.normal_stiffness_N_per_m / 2.0) / diameter_m;
    if (static_overlap > 0.01)
        throw UserError(
            fmt::format("the contacts are too soft: one grain's weight causes an overlap of {:.2g} of its diameter", static_overlap),
            {.allowed = "1 % of the diameter",
             .fix = fmt::format("set normal_stiffness_N_per_m to {:.2g} or more, tangential_stiffness_N_per_m to half of it",
                                config.normal_stiffness_N_per_m * static_overlap / 0.001)});
    ContactTimes times{.contact_time_s = contact_time(lightest_kg, config)};
    // A dashpot must not reverse a velocity within a step when several contacts act on one end of a grain.
    const double mass = lightest_kg / 2.0;
    const double rate = std::max(config.normal_damping * std::sqrt(2.0 * config.normal_stiffness_N_per_m / mass),
                                 config.tangential_damping * std::sqrt(2.0 * config.tangential_stiffness_N_per_m / mass));
    const double crowd = std::sqrt(std::max(1.0, static_cast<double>(at_once) / 6.0));
    const double automatic = std::min(times.contact_time_s / 45.0, rate > 0.0 ? 0.06 / rate : 1e300) / crowd;
    times.time_step_s = config.time_step_s > 0.0 ? config.time_step_s : automatic;
    if (times.time_step_s > times.contact_time_s / 30.0)
        throw UserError(
            fmt::format("the time step {:.3g} s is too long: a contact lasts {:.3g} s", times.time_step_s, times.contact_time_s),
            {.allowed = fmt::format("up to {:.3g} s (1/30 of the contact; longer steps never come to rest or lose grains)",
                                    times.contact_time_s / 30.0)});
    return times;
}

namespace {

// A grain that falls onto a bed at rest goes so deep that its energy m v^2 / 2 is (s_n / 4) O^2. The heaviest one may fall onto the
// thinnest.
void require_no_crossing(const std::vector<ShapeShare>& shapes, double largest_volume_m3, double drop_height_m,
                         const PackingConfig& config) {
    double thickness = 1e300;
    for (const auto& [shape, share] : shapes)
        if (shape.body != nullptr) thickness = std::min(thickness, shape.body->thickness());
    const double mass = config.density_kg_per_m3 * largest_volume_m3,
                 speed2 = 2.0 * config.gravity_m_per_s2 * drop_height_m + std::pow(config.horizontal_speed_m_per_s, 2),
                 overlap = std::sqrt(2.0 * mass * speed2 / config.normal_stiffness_N_per_m), deepest = deepest_overlap * thickness;
    if (overlap <= deepest) return;
    throw UserError(
        fmt::format("grains {:.3g} m thick that fall at {:.3g} m/s would pass through each other: they would overlap by {:.2g} m",
                    thickness, std::sqrt(speed2), overlap),
        {.allowed = fmt::format("an overlap of {:g} of the thickness", deepest_overlap),
         .fix = fmt::format("set normal_stiffness_N_per_m to {:.2g} or more, tangential_stiffness_N_per_m to half of it; or lower "
                            "drop_height_m",
                            1.2 * config.normal_stiffness_N_per_m * std::pow(overlap / deepest, 2))});
}

}  // namespace

SphereClump clump_for(const Shape& shape, const PackingConfig& config) {
    if (config.clump_spheres > 0) return clump_of_at_most(shape, config.clump_spheres);
    const double tolerance = config.surface_tolerance * smallest_diameter(shape);
    return {.spheres = sphere_clump(shape, tolerance), .tolerance_m = tolerance};
}

std::vector<Capsule> clump_spheres_for(const Shape& shape, const PackingConfig& config) {
    std::vector<Capsule> spheres = clump_for(shape, config).spheres;
    return shape.body == nullptr ? spheres : with_volume(std::move(spheres), measure(shape, 1e-6).volume_m3);
}

namespace {

// Where grains fall, z is not periodic; where they are scattered, all axes are, and a step of the protocol presses them together.
void require_way_of_filling(const Container& container, const PackingConfig& config, const ProtocolConfig& protocol) {
    const std::array<bool, 3> periodic = container.periodic();
    if (periodic[2] && config.fill != Fill::scatter)
        throw UserError("grains fall along z: the container cannot be periodic there",
                        {.fix = "periodic = [true, true, false] with engine = \"capsule\"; a bed without walls with fill = \"scatter\"; or "
                                "give a packing.json with engine = \"none\""});
    if (!protocol.none() && config.engine == Engine::none)
        throw UserError("steps of [protocol] need an engine",
                        {.where = "[packing]", .allowed = "engine = \"capsule\" or \"liggghts\"", .fix = "remove [protocol]"});
    if (config.engine == Engine::liggghts) require_steps_of_liggghts(protocol);
    if (config.fill != Fill::scatter) return;
    if (!(periodic[0] && periodic[1] && periodic[2]))
        throw UserError("fill = \"scatter\" needs a box without walls",
                        {.where = "[container]", .allowed = "kind = \"box\", periodic = [true, true, true]"});
    if (protocol.none())
        throw UserError("scattered grains do not touch each other: this is no bed yet",
                        {.where = "[protocol]", .fix = "[[protocol.step]] kind = \"compress\", pressure_Pa = 100"});
    if (config.grains == 0) throw UserError("fill = \"scatter\" needs the number of grains", {.where = "[packing]", .fix = "grains = 500"});
}

}  // namespace

PourPlan plan_pour(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                   const ProtocolConfig& protocol) {
    require_protocol(protocol, container);
    require_way_of_filling(container, config, protocol);
    const double d = finest_diameter(shapes);
    const double extent = maximum_feret_diameter(shapes);
    const double width = container.widest_place().width_m;
    if (extent > width || 2.0 * extent > container.height())
        throw UserError(
            fmt::format("the grain is too large for the container: it measures {:.4g} m, the container is {:.4g} m wide and {:.4g} m high",
                        extent, width, container.height()),
            {.allowed = "a container wider than one maximum Feret diameter and higher than two",
             .fix = "check the units (metres), use a larger container or smaller grains"});
    PourPlan plan;
    std::size_t at_once = 0;
    double mean_volume = 0.0, largest_volume = 0.0, smallest_volume = 1e300, mean_spheres = 0.0;
    for (const auto& [shape, share] : shapes) {
        const double volume = measure(shape, 1e-6).volume_m3;
        mean_volume += share * volume;
        at_once = std::max(at_once, contacts_at_once(shape));
        largest_volume = std::max(largest_volume, volume);
        smallest_volume = std::min(smallest_volume, volume);
        if (config.engine != Engine::liggghts) continue;
        const std::size_t spheres = clump_for(shape, config).spheres.size();
        mean_spheres += share * static_cast<double>(spheres);
        // Where two faces meet, up to half of the spheres are in contact: with a longer step, grains at rest shake on and on.
        if (shape.body != nullptr) at_once = std::max(at_once, spheres / 2);
    }
    plan.grain_mass_kg = config.density_kg_per_m3 * mean_volume;
    const ContactTimes times =
        contact_times(config.density_kg_per_m3 * smallest_volume, config.density_kg_per_m3 * largest_volume, d, at_once, config);
    plan.contact_time_s = times.contact_time_s;
    plan.time_step_s = times.time_step_s;
    require_gentle_steps(protocol, container,
                         {.diameter_m = d,
                          .heaviest_kg = config.density_kg_per_m3 * largest_volume,
                          .contact_time_s = times.contact_time_s,
                          .deepest_overlap = deepest_overlap,
                          .normal_stiffness_N_per_m = config.normal_stiffness_N_per_m,
                          .gravity_m_per_s2 = config.gravity_m_per_s2});
    plan.fill_height_m = config.fill_height_m > 0.0 ? config.fill_height_m : container.height() / 2.0;
    plan.drop_height_m = config.drop_height_m > 0.0 ? config.drop_height_m : container.height() - extent;
    if (config.grains == 0 && plan.fill_height_m > plan.drop_height_m - extent)
        throw UserError(fmt::format("the bed would reach the level where grains are created: fill height {:.4g} m, drop height {:.4g} m",
                                    plan.fill_height_m, plan.drop_height_m),
                        {.allowed = fmt::format("a fill height up to {:.4g} m", plan.drop_height_m - extent),
                         .fix = "use a higher container or a lower fill_height_m"});
    // Poured grains of these shapes fill at most 3/4 of the space.
    const double maximum = 0.75 * container.vessel().mean_area({0.0, plan.drop_height_m}) * plan.drop_height_m / mean_volume;
    if (config.fill != Fill::scatter && static_cast<double>(config.grains) > maximum)
        throw UserError(fmt::format("{} grains do not fit below the drop height", config.grains),
                        {.allowed = fmt::format("at most about {:.0f}", maximum), .fix = "use a higher container or fewer grains"});
    const double densest = 0.75 * container.vessel().mean_area({0.0, plan.fill_height_m}) * plan.fill_height_m / mean_volume;
    plan.max_grains = config.grains > 0 ? config.grains : std::max(1L, static_cast<long>(densest));
    plan.clump_spheres = std::lround(mean_spheres);
    if (config.fill != Fill::batches)
        plan.drop_height_m = 0.0;
    else
        require_no_crossing(shapes, largest_volume, plan.drop_height_m, config);
    add_expected_cost(plan, shapes, container, config, protocol, densest / 0.75 * poured_solid_fraction(shapes, container));
    return plan;
}

double mean_volume_m3(const std::vector<ShapeShare>& shapes) {
    double volume = 0.0;
    for (const auto& [shape, share] : shapes) volume += share * measure(shape, 1e-4).volume_m3;
    return volume;
}

double poured_solid_fraction(const std::vector<ShapeShare>& shapes, const Container& container) {
    double convexity = 0.0;
    for (const auto& [shape, share] : shapes) convexity += share * std::min(1.0, measure(shape, 1e-4).volume_m3 / hull(shape).volume_m3);
    const double wall = maximum_feret_diameter(shapes) / container.widest_place().width_m;
    return 0.67 * std::pow(convexity, 0.45) * std::max(0.5, 1.0 - 0.36 * wall);
}

double poured_height_m(const std::vector<ShapeShare>& shapes, const Container& container, long grains) {
    const double volume = static_cast<double>(grains) * mean_volume_m3(shapes) / poured_solid_fraction(shapes, container);
    double height = volume / container.inner_area_m2();
    for (int n = 0; n < 20; ++n) height = volume / container.vessel().mean_area({0.0, std::min(height, container.height())});
    return height + 0.6 * maximum_feret_diameter(shapes);
}

std::string scene_key(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                      const ProtocolConfig& protocol) {
    Json key = {{"container", to_json(container)}, {"packing", resolved_config(config)}, {"shapes", Json::array()}};
    if (!protocol.none()) key["protocol"] = resolved_config(protocol);
    for (const auto& [shape, share] : shapes) {
        if (shape.body != nullptr) key["shapes"].push_back({share, shape.body->to_json()});
        for (const Capsule& capsule : shape.capsules)
            key["shapes"].push_back(
                {share, capsule.a.x(), capsule.a.y(), capsule.a.z(), capsule.b.x(), capsule.b.y(), capsule.b.z(), capsule.radius});
    }
    return sha256(key.dump());
}

}  // namespace porepack::pouring
