#include "pouring/protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.hpp"
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

}  // namespace

void require_protocol(const ProtocolConfig& config, const Container& container) {
    const bool box = container.periodic()[2];
    bool shakes = false;
    const ProtocolStep* staying = nullptr;
    for (std::size_t i = 0; i < config.step.size(); ++i) {
        const ProtocolStep& step = config.step[i];
        const std::string kind(name_of(step.kind)), where = fmt::format("[[protocol.step]], step {} ({})", i + 1, kind);
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

std::optional<double> relative_acceleration(const ProtocolStep& step, double gravity_m_per_s2) {
    if (step.peak_acceleration_m_per_s2 > 0.0) return step.peak_acceleration_m_per_s2 / gravity_m_per_s2;
    if (step.kind != StepKind::vibrate) return std::nullopt;
    return step.amplitude_m * std::pow(2.0 * std::numbers::pi * step.frequency_Hz, 2) / gravity_m_per_s2;
}

}  // namespace porepack::pouring
