// Steps that press the grains together: plates, and a periodic box that shrinks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "pouring/dem/protocol_run.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr long between_pressures = 100;  // time steps between two checks of a plate that moves down, or of a porosity
constexpr double pressure_tolerance = 1e-3;

}  // namespace

void ProtocolRun::lay_lid() {
    if (at_.phase == Phase::begin) {
        dem_.set_lid(Lid{.height_m = dem_.rest().top_m + 1e-3 * scale_.diameter_m,
                         .velocity_m_per_s = 0.0,
                         .mass_kg = plate_mass_kg(step(), dem_.container(), config_.gravity_m_per_s2)});
        enter(Phase::move);
    }
    dem_.step(checked_steps);
    require_time("under the lid");
    if (steps_in_phase() < 2 * checked_steps || !lid_at_rest() || !at_rest(1.0, true)) return;
    measure(true);
    if (step().stays) return finish_step();
    dem_.set_lid({});
    enter(Phase::rest);
}

void ProtocolRun::change_friction() {
    if (step().friction >= 0.0) at_.friction = step().friction;
    dem_.set_friction(at_.friction);
}

// The plate moves evenly until the end is reached. Then it stands still, or, for a pressure, gets the mass whose weight this is.
void ProtocolRun::press_down() {
    const double area = dem_.container().inner_area_m2(), speed = plate_speed_m_per_s(step(), scale_.diameter_m, config_.gravity_m_per_s2);
    if (at_.phase == Phase::begin) {
        change_friction();
        const double top = dem_.rest().top_m + 1e-3 * scale_.diameter_m;
        if (step().to_height_m >= top)
            throw UserError(fmt::format("the plate would not touch the bed, which is {:.4g} m high", top),
                            {.where = fmt::format("[[protocol.step]], step {}", at_.step + 1), .allowed = "a to_height_m below that"});
        dem_.set_lid(Lid{.height_m = top, .velocity_m_per_s = -speed});
        enter(Phase::move);
    }
    if (dem_.lid()->velocity_m_per_s != 0.0 && dem_.lid()->mass_kg == 0.0) {
        const long left = step().to_height_m > 0.0 ? std::max(1L, std::lround((dem_.lid()->height_m - step().to_height_m) / speed / dt_))
                                                   : between_pressures;
        dem_.step(std::min(between_pressures, left));
        Lid lid = *dem_.lid();
        const bool soft = dem_.rest().mean_overlap_m > softest_overlap * scale_.diameter_m;
        if (step().pressure_Pa > 0.0 && lid.force_N >= step().pressure_Pa * area) {
            lid.mass_kg = plate_mass_kg(step(), dem_.container(), config_.gravity_m_per_s2);
            at_.reached = true;
        } else if (step().to_height_m > 0.0) {
            at_.reached = lid.height_m <= step().to_height_m + 0.5 * dt_ * speed;
        } else if (step().to_porosity > 0.0) {
            at_.reached = bed_state(dem_.packing(), scale_.feret_diameter_m).porosity <= step().to_porosity;
        }
        if (!at_.reached && !soft) return;
        if (!at_.reached) warn_of_soft_grains();
        if (lid.mass_kg == 0.0) lid.velocity_m_per_s = 0.0;
        dem_.set_lid(lid);
        at_.since = dem_.steps();
        return;
    }
    dem_.step(checked_steps);
    require_time("under the plate");
    if (steps_in_phase() < 2 * checked_steps || !lid_at_rest() || !at_rest(1.0, false)) return;
    measure(at_.reached);
    if (step().stays) return finish_step();
    dem_.set_lid({});
    enter(Phase::rest);
}

// The box shrinks evenly until grains press on each other. From then on its rate is so small that the pressure grows, and falls, within the
// time d sqrt(density / pressure), in which a grain moves by its diameter under this pressure.
ProtocolRun::Pace ProtocolRun::pace() const {
    const double d = scale_.diameter_m, k = 0.5 * config_.normal_stiffness_N_per_m;
    // Of a step that ends with a porosity: a pressure that overlaps of one part in 1000 cause.
    const double target = step().pressure_Pa > 0.0 ? step().pressure_Pa : 1e-3 * k / d;
    const double time = d * std::sqrt(config_.density_kg_per_m3 / target), size = dem_.container().size().minCoeff();
    const double fastest = step().speed_m_per_s > 0.0 ? step().speed_m_per_s / size : 0.01 / time;
    return {.pressure_Pa = target, .fastest_per_s = fastest, .slowest_per_s = std::min(fastest, target * d / k / time)};
}

void ProtocolRun::shrink() {
    if (at_.phase == Phase::begin) {
        dem_.set_gravity(Vec3::Zero());
        change_friction();
        enter(Phase::move);
    }
    if (at_.phase == Phase::rest) return rest_in_box();
    step().to_porosity > 0.0 ? shrink_to_porosity() : shrink_to_pressure();
    if (at_.phase == Phase::move && dem_.rest().mean_overlap_m > softest_overlap * scale_.diameter_m) {
        warn_of_soft_grains();
        enter(Phase::rest);
    }
}

void ProtocolRun::shrink_to_pressure() {
    const Pace pace = this->pace();
    for (long n = 0; n < checked_steps; ++n) {
        const double pressure = dem_.pressure_Pa(), part = std::clamp(1.0 - pressure / pace.pressure_Pa, -1.0, 1.0);
        const double rate = pressure < 0.01 * pace.pressure_Pa ? pace.fastest_per_s : part * pace.slowest_per_s;
        dem_.resize(dem_.container().size() * (1.0 - std::min(1e-3, rate * dt_)));
        dem_.step();
    }
    if (std::abs(dem_.pressure_Pa() / pace.pressure_Pa - 1.0) < pressure_tolerance && still_in_box()) {
        measure(true);
        return finish_step();
    }
    require_time("in the periodic box");
}

// Overlaps do not count: they are small.
void ProtocolRun::shrink_to_porosity() {
    double solid = 0.0;
    for (std::size_t i = 0; i < dem_.size(); ++i) solid += dem_.grain(dem_.pose(i).shape).mass_kg / config_.density_kg_per_m3;
    const double aim = solid / (1.0 - step().to_porosity), smallest = 1.0 - std::min(1e-3, pace().fastest_per_s * dt_);
    for (long n = 0; n < checked_steps; ++n) {
        const double ratio = std::cbrt(aim / dem_.container().size().prod());
        at_.reached = ratio >= smallest;
        if (ratio < 1.0) dem_.resize(dem_.container().size() * std::max(ratio, smallest));
        dem_.step();
        if (at_.reached) return enter(Phase::rest);
    }
}

// Nothing supports a loose bed: what moves is stopped after each part, until the contacts push no more.
void ProtocolRun::rest_in_box() {
    dem_.step(checked_steps);
    if (still_in_box()) {
        measure(at_.reached);
        return finish_step();
    }
    dem_.stop();
    require_time("in the periodic box");
}

// Without friction nothing stops a round grain that spins about its axis.
bool ProtocolRun::still_in_box() const {
    const DemRest rest = dem_.rest();
    const double d = scale_.diameter_m, force = std::max(dem_.pressure_Pa(), 1e-3 * pace().pressure_Pa) * d * d;
    return rest.translation_energy_per_grain_J < config_.rest_energy_fraction * force * d &&
           rest.mean_net_force_N < rest_force_limit * force;
}

}  // namespace porepack::pouring::dem
