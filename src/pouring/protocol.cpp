#include "pouring/protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string>

#include "core/error.hpp"
#include "packing/grains.hpp"
#include "packing/porosity.hpp"
#include "packing/section.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring {
namespace {

struct Key {
    const char* name;
    bool given;
    std::vector<StepKind> of;
};

std::vector<Key> keys_of(const ProtocolStep& s) {
    using enum StepKind;
    return {{"number", s.number > 0, {tap}},
            {"height_m", s.height_m > 0.0, {tap}},
            {"peak_acceleration_m_per_s2", s.peak_acceleration_m_per_s2 > 0.0, {tap, vibrate}},
            {"frequency_Hz", s.frequency_Hz > 0.0, {tap, vibrate}},
            {"amplitude_m", s.amplitude_m > 0.0, {vibrate}},
            {"time_s", s.time_s > 0.0, {vibrate}},
            {"direction", !s.direction.empty(), {vibrate}},
            {"mass_kg", s.mass_kg > 0.0, {lid}},
            {"pressure_Pa", s.pressure_Pa > 0.0, {lid, compress}},
            {"to_height_m", s.to_height_m > 0.0, {compress}},
            {"to_porosity", s.to_porosity > 0.0, {compress}},
            {"speed_m_per_s", s.speed_m_per_s > 0.0, {compress}},
            {"friction", s.friction >= 0.0, {compress}},
            {"stays", s.stays, {lid, compress}}};
}

// The first complaint about a step: what is wrong, and what is allowed.
struct Fault {
    std::string what, allowed;
};

std::optional<Fault> missing_or_double(const ProtocolStep& s, bool box) {
    const auto one_of = [](std::initializer_list<bool> given) { return std::count(given.begin(), given.end(), true) == 1; };
    const bool height = s.height_m > 0.0, peak = s.peak_acceleration_m_per_s2 > 0.0, frequency = s.frequency_Hz > 0.0,
               pressure = s.pressure_Pa > 0.0;
    switch (s.kind) {
        case StepKind::settle:
            return {};
        case StepKind::tap:
            if (one_of({height, peak}) && peak == frequency) return {};
            return Fault{"a tap needs its strength", "height_m, or peak_acceleration_m_per_s2 and frequency_Hz"};
        case StepKind::vibrate:
            if (!one_of({s.amplitude_m > 0.0, peak}) || !frequency || !(s.time_s > 0.0))
                return Fault{"vibration needs its strength, frequency and time",
                             "amplitude_m or peak_acceleration_m_per_s2, frequency_Hz and time_s"};
            if (!s.direction.empty() && !(Vec3(s.direction[0], s.direction[1], s.direction[2]).norm() > 0.0))
                return Fault{"`direction` has no length", "[0, 0, 1], or another vector"};
            return {};
        case StepKind::lid:
            if (one_of({s.mass_kg > 0.0, pressure})) return {};
            return Fault{"a lid needs its weight", "mass_kg or pressure_Pa"};
        case StepKind::compress:
            if (box && s.to_height_m > 0.0)
                return Fault{"a periodic box has no plate: `to_height_m` has no effect", "pressure_Pa or to_porosity"};
            if (box && s.stays) return Fault{"a periodic box has no plate that could stay", "compress without `stays`"};
            if (one_of({s.to_height_m > 0.0, pressure, s.to_porosity > 0.0})) return {};
            return Fault{"compression needs its end", box ? "pressure_Pa or to_porosity" : "one of to_height_m, pressure_Pa, to_porosity"};
    }
    return {};
}

std::string where_is(const ProtocolStep& step, std::size_t index) {
    return fmt::format("[[protocol.step]], step {} ({})", index + 1, name_of(step.kind));
}

void require_gentle(const ProtocolStep& step, const std::string& where, const Container& container, const StepLimits& limits) {
    const double stiffness = limits.normal_stiffness_N_per_m, d = limits.diameter_m;
    double speed = step.speed_m_per_s;
    if (step.kind == StepKind::tap || step.kind == StepKind::vibrate) {
        speed = step.height_m > 0.0 ? fall_speed(step, limits.gravity_m_per_s2)
                                    : peak_acceleration(step).norm() / (2.0 * std::numbers::pi * step.frequency_Hz);
        const double fastest = 0.25 / limits.contact_time_s;
        if (step.frequency_Hz > fastest)
            throw UserError(
                fmt::format("a period of {:.3g} s is too short: a contact lasts {:.3g} s", 1.0 / step.frequency_Hz, limits.contact_time_s),
                {.where = where, .allowed = fmt::format("frequency_Hz up to {:.3g}", fastest)});
    }
    // A grain that meets a wall with this speed goes so deep that m v^2 / 2 = (s_n / 4) O^2.
    const double overlap = speed * std::sqrt(2.0 * limits.heaviest_kg / stiffness), deepest = limits.deepest_overlap * d;
    if (overlap > deepest)
        throw UserError(fmt::format("at {:.3g} m/s, grains {:.3g} m thick would pass through each other", speed, d),
                        {.where = where,
                         .allowed = fmt::format("{:.3g} m/s with this stiffness", speed * deepest / overlap),
                         .fix = "a gentler step, or a larger normal_stiffness_N_per_m"});
    if (step.kind == StepKind::lid)
        if (const double mass = plate_mass_kg(step, container, limits.gravity_m_per_s2); mass < limits.heaviest_kg)
            throw UserError(fmt::format("the lid has a mass of {:.3g} kg, a grain {:.3g} kg", mass, limits.heaviest_kg),
                            {.where = where, .allowed = "a lid heavier than a grain"});
    if (const double soft = 2.0 * step.pressure_Pa * d / stiffness; soft > softest_overlap)
        throw UserError(fmt::format("a pressure of {:.3g} Pa would press grains into each other by about {:.2g} of their diameter",
                                    step.pressure_Pa, soft),
                        {.where = where,
                         .allowed = fmt::format("{:g}", softest_overlap),
                         .fix = fmt::format("normal_stiffness_N_per_m of {:.2g} or more, tangential_stiffness_N_per_m half of it",
                                            2.0 * step.pressure_Pa * d / (0.1 * softest_overlap))});
}

}  // namespace

void require_protocol(const ProtocolConfig& config, const Container& container) {
    const bool box = container.periodic()[2];
    bool shakes = false;
    const ProtocolStep* staying = nullptr;
    for (std::size_t i = 0; i < config.step.size(); ++i) {
        const ProtocolStep& step = config.step[i];
        const std::string kind(name_of(step.kind)), where = where_is(step, i);
        for (const Key& key : keys_of(step))
            if (key.given && std::find(key.of.begin(), key.of.end(), step.kind) == key.of.end())
                throw UserError(fmt::format("`{}` has no effect on a step of kind \"{}\"", key.name, kind),
                                {.where = where, .fix = "remove it"});
        if (const auto fault = missing_or_double(step, box)) throw UserError(fault->what, {.where = where, .allowed = fault->allowed});
        if (box && step.kind != StepKind::compress)
            throw UserError("in a box that is periodic along x, y and z grains have no weight",
                            {.where = where, .allowed = "kind = \"compress\""});
        if (staying != nullptr && (step.kind == StepKind::lid || step.kind == StepKind::compress))
            throw UserError("a plate stays on the bed since an earlier step", {.where = where, .allowed = "one plate at a time"});
        if (!box && (step.kind == StepKind::lid || step.kind == StepKind::compress)) {
            require_prism(container, fmt::format("step {} of [protocol]: a plate that moves down", i + 1));
            if (step.stays) staying = &step;
        }
        shakes = shakes || step.kind == StepKind::tap || step.kind == StepKind::vibrate;
    }
    if (config.target_porosity > 0.0 && !shakes)
        throw UserError("`target_porosity` needs taps or vibration",
                        {.where = "[protocol]", .fix = "[[protocol.step]] kind = \"tap\", number = 200, height_m = 0.002"});
}

void require_steps_of_liggghts(const ProtocolConfig& config) {
    const auto refuse = [](const char* what, const std::string& where) {
        throw UserError(fmt::format("LIGGGHTS does not carry out {}", what), {.where = where, .fix = "engine = \"capsule\""});
    };
    if (config.target_porosity > 0.0) refuse("`target_porosity`: it does not know the porosity of the grains", "[protocol]");
    for (std::size_t i = 0; i < config.step.size(); ++i) {
        const ProtocolStep& step = config.step[i];
        const std::string where = where_is(step, i);
        if (step.to_porosity > 0.0) refuse("`to_porosity`: it does not know the porosity of the grains", where);
        if (step.friction >= 0.0) refuse("a change of `friction`", where);
        if (step.stays && i + 1 < config.step.size()) refuse("further steps under a plate that stays", where);
    }
}

void require_gentle_steps(const ProtocolConfig& config, const Container& container, const StepLimits& limits) {
    for (std::size_t i = 0; i < config.step.size(); ++i) require_gentle(config.step[i], where_is(config.step[i], i), container, limits);
}

std::optional<double> relative_acceleration(const ProtocolStep& step, double gravity_m_per_s2) {
    if (step.peak_acceleration_m_per_s2 > 0.0) return step.peak_acceleration_m_per_s2 / gravity_m_per_s2;
    if (step.kind != StepKind::vibrate) return std::nullopt;
    return step.amplitude_m * std::pow(2.0 * std::numbers::pi * step.frequency_Hz, 2) / gravity_m_per_s2;
}

Vec3 peak_acceleration(const ProtocolStep& step) {
    const Vec3 direction =
        step.direction.empty() ? Vec3(Vec3::UnitZ()) : Vec3(step.direction[0], step.direction[1], step.direction[2]).normalized();
    return *relative_acceleration(step, 1.0) * direction;
}

double fall_speed(const ProtocolStep& step, double gravity_m_per_s2) {
    return std::sqrt(2.0 * gravity_m_per_s2 * step.height_m);
}

long period_steps(const ProtocolStep& step, double time_step_s) {
    return std::max(1L, std::lround(1.0 / (step.frequency_Hz * time_step_s)));
}

long whole_periods(const ProtocolStep& step, double time_step_s) {
    return std::lround(std::ceil(step.time_s / time_step_s / static_cast<double>(period_steps(step, time_step_s)) - 1e-9));
}

double plate_mass_kg(const ProtocolStep& step, const Container& container, double gravity_m_per_s2) {
    return step.mass_kg > 0.0 ? step.mass_kg : step.pressure_Pa * container.inner_area_m2() / gravity_m_per_s2;
}

double plate_speed_m_per_s(const ProtocolStep& step, double diameter_m, double gravity_m_per_s2) {
    return step.speed_m_per_s > 0.0 ? step.speed_m_per_s : 0.05 * std::sqrt(gravity_m_per_s2 * diameter_m);
}

BedState bed_state(const Packing& packing, double feret_diameter_m) {
    constexpr long lines = 10000;
    const Grains grains(packing);
    const Container& container = packing.container;
    const bool in_box = container.periodic()[2];
    const Bounds bounds = grains.bounds();
    const Section bed = whole_bed(container, {std::max(0.0, bounds.low.z()), bounds.high.z()});
    if (in_box) return {container.height(), packing::porosity(grains, container, bed, lines).value};
    // The automatic section; of a low bed its middle half, so that a tap does not decide which of both it is.
    const double trim = std::min({0.03, feret_diameter_m, 0.25 * bed.length()});
    return {bounds.high.z(), packing::porosity(grains, container, {bed.z0_m + trim, bed.z1_m - trim}, lines).value};
}

}  // namespace porepack::pouring
