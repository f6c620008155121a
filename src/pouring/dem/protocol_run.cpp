#include "pouring/dem/protocol_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <istream>
#include <numbers>
#include <ostream>

#include "core/error.hpp"
#include "core/log.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

Vec3 gravity_of(const PackingConfig& config) {
    return {0.0, 0.0, -config.gravity_m_per_s2};
}

}  // namespace

ProtocolRun::ProtocolRun(const ProtocolConfig& protocol, const PackingConfig& config, const ProtocolScale& scale, CapsuleDem& dem)
    : protocol_(protocol), config_(config), scale_(scale), dem_(dem), dt_(scale.plan.time_step_s) {
    at_.friction = config.friction;
}

bool ProtocolRun::in_box() const {
    return dem_.container().periodic()[2];
}

void ProtocolRun::begin() {
    rows_.clear();
    if (in_box()) return;
    measure(true);
    rows_.back().step = rows_.back().repeat = 0;
}

// Grains may sleep while they come to rest, and only then: so a resumed run has the same bits.
void ProtocolRun::enter(Phase phase) {
    dem_.set_sleep(false);
    at_.phase = phase;
    at_.since = dem_.steps();
}

void ProtocolRun::finish_step() {
    ++at_.step;
    at_.repeat = at_.measured = 0;
    at_.reached = false;
    enter(Phase::begin);
}

void ProtocolRun::advance() {
    dem_.set_friction(at_.friction);
    switch (step().kind) {
        case StepKind::settle:
            if (at_.phase == Phase::begin) enter(Phase::rest);
            return rest_after();
        case StepKind::tap:
            return at_.phase == Phase::rest ? rest_after() : tap();
        case StepKind::vibrate:
            return at_.phase == Phase::rest ? rest_after() : vibrate();
        case StepKind::lid:
            return at_.phase == Phase::rest ? rest_after() : lay_lid();
        case StepKind::compress:
            if (in_box()) return shrink();
            return at_.phase == Phase::rest ? rest_after() : press_down();
    }
}

long ProtocolRun::period() const {
    return period_steps(step(), dt_);
}

void ProtocolRun::warn_of_soft_grains() const {
    log_warning(fmt::format("pour: step {} ends before its aim: grains overlap by more than {:g} of their diameter on average",
                            at_.step + 1, softest_overlap));
}

// The vessel's position is a (1 - cos w t): it starts from rest, and is at rest after each whole period.
void ProtocolRun::shake(long until) {
    const Vec3 acceleration = peak_acceleration(step());
    while (dem_.steps() < until) {
        const double turns = (static_cast<double>(steps_in_phase()) + 0.5) / static_cast<double>(period());
        dem_.set_gravity(gravity_of(config_) - std::cos(2.0 * std::numbers::pi * turns) * acceleration);
        dem_.step();
    }
    dem_.set_gravity(gravity_of(config_));
}

// A vessel that falls does not load its grains; when it stops, all of them have its velocity.
void ProtocolRun::tap() {
    if (at_.phase == Phase::begin) enter(Phase::move);
    if (step().height_m > 0.0) {
        dem_.push(Vec3(0.0, 0.0, -fall_speed(step(), config_.gravity_m_per_s2)));
        enter(Phase::rest);
        return rest_after();  // each call takes time steps, so that a run which is stopped again and again comes to an end
    }
    const long end = at_.since + period();
    shake(std::min(end, dem_.steps() + checked_steps));
    if (dem_.steps() == end) enter(Phase::rest);
}

void ProtocolRun::vibrate() {
    const long all = whole_periods(step(), dt_), length = all * period();
    if (at_.phase == Phase::begin) {
        log_info("pour: vibration with {:.3g} times gravity for {:.3g} s", *relative_acceleration(step(), config_.gravity_m_per_s2),
                 static_cast<double>(length) * dt_);
        enter(Phase::move);
    }
    shake(std::min(at_.since + length, dem_.steps() + checked_steps));
    // Rows between whole periods, when the vessel is at rest.
    const long due = steps_in_phase() / period() * std::min(all, rows_of_vibration) / all;
    if (due > at_.measured && steps_in_phase() < length) {
        at_.measured = due;
        measure(true);
        at_.reached = protocol_.target_porosity > 0.0 && rows_.back().porosity <= protocol_.target_porosity;
    }
    if (steps_in_phase() >= length || at_.reached) enter(Phase::rest);
}

bool ProtocolRun::lid_at_rest() const {
    if (!dem_.lid()) return true;
    const Lid& lid = *dem_.lid();
    if (lid.mass_kg == 0.0) return lid.velocity_m_per_s == 0.0;
    const double weight = lid.mass_kg * config_.gravity_m_per_s2;
    return std::abs(lid.force_N - weight) < 0.1 * rest_force_limit * weight &&
           0.5 * lid.mass_kg * lid.velocity_m_per_s * lid.velocity_m_per_s < scale_.rest_limit_J;
}

bool ProtocolRun::at_rest(double factor, bool balanced) const {
    const DemRest rest = dem_.rest();
    return rest.kinetic_energy_per_grain_J < factor * scale_.rest_limit_J &&
           (!balanced || dem_.sleeping() > 0 || rest.mean_force_over_weight < rest_force_limit);
}

void ProtocolRun::require_time(const char* what) const {
    const double limit = in_box() ? 10.0 * config_.settle_time_s : config_.settle_time_s;
    if (static_cast<double>(steps_in_phase()) * dt_ > limit)
        throw NumericalError(fmt::format("the grains are not at rest {:g} s after step {} of [protocol], {}", limit, at_.step + 1, what),
                             {.fix = at_.friction > 0.0 ? "raise settle_time_s, or shorten time_step_s"
                                                        : "a friction of 0.01 in this step: without any, round grains may turn for ever"});
}

// Under a plate that stays, no grain sleeps.
void ProtocolRun::rest_after() {
    const bool is_tap = step().kind == StepKind::tap;
    if (steps_in_phase() == 0) dem_.set_sleep(config_.sleep && !dem_.lid());
    dem_.step(checked_steps);
    const bool long_enough = static_cast<double>(steps_in_phase()) * dt_ > 0.02,
               late = static_cast<double>(steps_in_phase()) * dt_ > config_.settle_time_s;
    if (!(is_tap && late)) {  // grains that roll on do not keep the next tap from coming
        if (!late && !(long_enough && at_rest(is_tap ? tap_rest_factor : 1.0, false) && lid_at_rest())) return;
        require_time("without motion of the vessel");
    }
    const bool aims = protocol_.target_porosity > 0.0 && (is_tap || step().kind == StepKind::vibrate);
    measure(true);
    if (aims) rows_.back().reached = at_.reached = rows_.back().porosity <= protocol_.target_porosity;
    if (!is_tap) return finish_step();
    ++at_.repeat;
    if (at_.repeat >= std::max(1L, step().number) || (aims && at_.reached)) return finish_step();
    enter(Phase::begin);
}

void ProtocolRun::measure(bool reached) {
    const DemRest rest = dem_.rest();
    ProtocolRow row{.step = static_cast<long>(at_.step) + 1,
                    .kind = step().kind,
                    .repeat = step().kind == StepKind::tap ? at_.repeat + 1
                              : at_.phase == Phase::move   ? at_.measured
                                                           : 0,
                    .time_s = dem_.time_s(),
                    .coordination_number = rest.coordination_number,
                    .coordination_without_rattlers = rest.coordination_without_rattlers,
                    .rattlers = rest.rattlers,
                    .pressure_Pa = in_box() ? dem_.pressure_Pa() : 0.0,
                    .reached = reached};
    const BedState bed = bed_state(dem_.packing(), scale_.feret_diameter_m);
    row.bed_height_m = bed.height_m;
    row.porosity = bed.porosity;
    if (dem_.lid()) {
        row.lid_height_m = dem_.lid()->height_m;
        row.lid_force_N = dem_.lid()->force_N;
        row.pressure_Pa = row.lid_force_N / dem_.container().inner_area_m2();
    }
    rows_.push_back(row);
    if (const double soft = rest.mean_overlap_m / scale_.diameter_m; soft > softest_overlap && dem_.lid())
        log_warning(
            fmt::format("pour: after step {} the grains overlap by {:.2g} of their diameter on average: a larger "
                        "normal_stiffness_N_per_m makes them harder",
                        row.step, soft));
}

std::string ProtocolRun::text() const {
    const std::size_t n = std::min(at_.step, protocol_.step.size() - 1);
    const ProtocolStep& now = protocol_.step[n];
    std::string text = fmt::format("step {} of {}, {}", n + 1, protocol_.step.size(), name_of(now.kind));
    if (now.kind == StepKind::tap) text += fmt::format(" {} of {}", at_.repeat + 1, std::max(1L, now.number));
    if (in_box()) {
        const DemRest rest = dem_.rest();
        const double d = scale_.diameter_m, force = std::max(1e-300, dem_.pressure_Pa() * d * d);
        text += fmt::format(", box {:.4g} m, {:.3g} Pa, energy {:.1g}, force {:.1g} of p d3, p d2", dem_.container().size().minCoeff(),
                            dem_.pressure_Pa(), rest.translation_energy_per_grain_J / (force * d), rest.mean_net_force_N / force);
    }
    if (!rows_.empty()) text += fmt::format(", porosity {:.4f}", rows_.back().porosity);
    return text;
}

double ProtocolRun::fraction_done() const {
    double done = 0.0, all = 0.0;
    for (std::size_t i = 0; i < protocol_.step.size(); ++i) {
        const double weight = static_cast<double>(std::max(1L, protocol_.step[i].number));
        all += weight;
        if (i < at_.step) done += weight;
        if (i == at_.step) done += static_cast<double>(at_.repeat);
        if (i == at_.step && protocol_.step[i].kind == StepKind::vibrate)
            done += std::min(1.0, static_cast<double>(at_.measured) / rows_of_vibration);
    }
    return done / std::max(1.0, all);
}

void ProtocolRun::save(std::ostream& out) const {
    const std::size_t count = rows_.size();
    out.write(reinterpret_cast<const char*>(&at_), sizeof at_);
    out.write(reinterpret_cast<const char*>(&count), sizeof count);
    for (const ProtocolRow& row : rows_) out.write(reinterpret_cast<const char*>(&row), sizeof row);
}

bool ProtocolRun::load(std::istream& in) {
    std::size_t count = 0;
    in.read(reinterpret_cast<char*>(&at_), sizeof at_);
    in.read(reinterpret_cast<char*>(&count), sizeof count);
    if (!in || count > 10000000 || at_.step > protocol_.step.size()) return false;
    rows_.assign(count, {});
    for (ProtocolRow& row : rows_) in.read(reinterpret_cast<char*>(&row), sizeof row);
    if (in_box()) dem_.set_gravity(Vec3::Zero());
    if (begun() && !done() && (at_.phase != Phase::rest || steps_in_phase() == 0 || dem_.lid())) dem_.set_sleep(false);
    dem_.set_friction(at_.friction);
    return static_cast<bool>(in);
}

}  // namespace porepack::pouring::dem
