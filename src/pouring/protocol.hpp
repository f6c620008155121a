// Table [protocol] of case.toml: what is done to a bed after it was poured.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/choice.hpp"
#include "packing/packing.hpp"
#include "record/config.hpp"
#include "vessels/container.hpp"

namespace porepack::pouring {

/// settle: until the grains are at rest. tap: the vessel falls on its support, or is accelerated for one period, again and again. vibrate:
/// its position is a (1 - cos w t). lid: a plate is laid on the bed. compress: a plate moves down; or a box that is periodic along x, y and
/// z shrinks.
enum class StepKind { settle, tap, vibrate, lid, compress };
constexpr std::array<core::Choice<StepKind>, 5> choices_of(StepKind) {
    return {{{StepKind::settle, "settle"},
             {StepKind::tap, "tap"},
             {StepKind::vibrate, "vibrate"},
             {StepKind::lid, "lid"},
             {StepKind::compress, "compress"}}};
}

/// Meaning, unit, range and default of each key: see describe(). 0 stands for "not given".
struct ProtocolStep {
    StepKind kind = StepKind::settle;
    long number = 0;
    double height_m = 0.0;
    double peak_acceleration_m_per_s2 = 0.0;
    double frequency_Hz = 0.0;
    double amplitude_m = 0.0;
    double time_s = 0.0;
    std::vector<double> direction = {};
    double mass_kg = 0.0;
    double pressure_Pa = 0.0;
    double to_height_m = 0.0;
    double to_porosity = 0.0;
    double speed_m_per_s = 0.0;
    double friction = -1.0;
    bool stays = false;
};

inline void describe(record::ConfigVisitor& v, ProtocolStep& c) {
    v.choice(
        "kind", c.kind,
        "settle: until the grains are at rest; tap: the vessel falls on its support, or is accelerated for one period; vibrate: it "
        "moves back and forth; lid: a plate is laid on the bed; compress: a plate moves down, or a box that is periodic along x, y and z "
        "shrinks");
    v.integer("number", c.number, {.low = 1, .high = 1e6, .zero_is_auto = true}, "tap: how many, each until the bed is at rest; auto: 1");
    v.number("height_m", c.height_m, {.low = 1e-9, .high = 10.0, .zero_is_auto = true},
             "tap: height from which the vessel falls; it stops at once. auto: peak_acceleration_m_per_s2 and frequency_Hz are given");
    v.number("peak_acceleration_m_per_s2", c.peak_acceleration_m_per_s2, {.low = 1e-3, .high = 1e5, .zero_is_auto = true},
             "tap: largest acceleration in one period, during which the vessel rises and comes back; auto: height_m is given");
    v.number("frequency_Hz", c.frequency_Hz, {.low = 0.1, .high = 1e5, .zero_is_auto = true},
             "tap with peak_acceleration_m_per_s2, and vibrate: frequency of the vessel's motion");
    v.number("amplitude_m", c.amplitude_m, {.low = 1e-9, .high = 1.0, .zero_is_auto = true}, "vibrate: amplitude of the motion");
    v.number("time_s", c.time_s, {.low = 1e-4, .high = 1e5, .zero_is_auto = true},
             "vibrate: simulated time, made longer to a whole number of periods");
    v.numbers("direction", c.direction, {3, 3}, record::between(-1e3, 1e3), "vibrate: direction; default: [0, 0, 1]");
    v.number("mass_kg", c.mass_kg, record::positive_or_auto(), "lid: mass of the plate; auto: from pressure_Pa");
    v.number("pressure_Pa", c.pressure_Pa, record::positive_or_auto(),
             "lid: weight of the plate over its area; compress: until the grains press on the plate, or in the periodic box, with this "
             "pressure");
    v.number("to_height_m", c.to_height_m, record::length_range_or_auto(), "compress: until the plate is at this height");
    v.number("to_porosity", c.to_porosity, {.low = 0.01, .high = 0.99, .zero_is_auto = true},
             "compress: until the section, or the periodic box, has this porosity");
    v.number("speed_m_per_s", c.speed_m_per_s, record::positive_or_auto(),
             "compress: speed of the plate, or of the periodic box's sides towards each other; auto: a plate's is 0.05 sqrt(g d) (d: "
             "smallest diameter or thickness), a box's 0.01 of its width in the time d sqrt(density / pressure)");
    v.number("friction", c.friction, {.low = -1.0, .high = 10.0},
             "compress: Coulomb friction between grains during this step and the following ones; -1: unchanged. 0: the densest beds");
    v.boolean("stays", c.stays, "lid, compress: the plate stays until the end; else it is taken away, and the bed comes to rest");
}

struct ProtocolConfig {
    double target_porosity = 0.0;
    std::vector<ProtocolStep> step = {};
    [[nodiscard]] bool none() const { return step.empty(); }
};

inline void describe(record::ConfigVisitor& v, ProtocolConfig& c) {
    v.number("target_porosity", c.target_porosity, {.low = 0.01, .high = 0.99, .zero_is_auto = true},
             "taps and vibration end when the section has this porosity; where they do not reach it, the result says so; auto: none");
    v.tables(
        "step",
        [&](std::size_t count) {
            if (count != record::keep_size) c.step.resize(count);
            return c.step.size();
        },
        [&](std::size_t i, record::ConfigVisitor& one) { describe(one, c.step[i]); }, "what is done to the bed, in this order");
}

/// What a step did; a tap is a row of its own.
struct ProtocolRow {
    long step = 0;  ///< 0: the pour
    StepKind kind = StepKind::settle;
    long repeat = 0;                            ///< number of the tap, or of the row during a vibration; 0 at rest after it
    double time_s = 0.0;                        ///< simulated since the pour began
    double bed_height_m = 0.0, porosity = 0.0;  ///< of the automatic section, of a low bed its middle half; or of the whole periodic box
    double coordination_number = 0.0;
    std::optional<double> coordination_without_rattlers = {};  ///< not known of a bed by LIGGGHTS
    std::optional<long> rattlers = {};
    double lid_height_m = 0.0, lid_force_N = 0.0;  ///< 0 without one
    double pressure_Pa = 0.0;                      ///< on the lid, or in the periodic box
    bool reached = true;                           ///< what the step was to reach
};

/// Throws UserError for a step whose keys do not belong to its kind, are missing or contradict each other, with its number.
void require_protocol(const ProtocolConfig& config, const vessels::Container& container);

/// Throws UserError for what LIGGGHTS's own fixes cannot do.
void require_steps_of_liggghts(const ProtocolConfig& config);

/// What limits the violence of a step.
struct StepLimits {
    double diameter_m = 0.0;  ///< smallest, or the smallest thickness
    double heaviest_kg = 0.0;
    double contact_time_s = 0.0;
    double deepest_overlap = 0.0;  ///< over the diameter, beyond which grains pass through each other
    double normal_stiffness_N_per_m = 0.0, gravity_m_per_s2 = 0.0;
};
/// Throws UserError for steps so violent that grains would pass through each other, too fast for a contact, or too heavy for its stiffness.
void require_gentle_steps(const ProtocolConfig& config, const vessels::Container& container, const StepLimits& limits);

/// Largest mean overlap of pressed grains over the diameter.
inline constexpr double softest_overlap = 0.02;

/// Largest acceleration of a vessel that is shaken with given acceleration or amplitude, with its direction.
[[nodiscard]] shapes::Vec3 peak_acceleration(const ProtocolStep& step);
/// Peak acceleration of a tap or a vibration over gravity; none of a tap by its height.
[[nodiscard]] std::optional<double> relative_acceleration(const ProtocolStep& step, double gravity_m_per_s2);
/// Speed of the grains after a tap by its height.
[[nodiscard]] double fall_speed(const ProtocolStep& step, double gravity_m_per_s2);
/// Time steps of one period of a vessel that is shaken, and whole periods of a vibration.
[[nodiscard]] long period_steps(const ProtocolStep& step, double time_step_s);
[[nodiscard]] long whole_periods(const ProtocolStep& step, double time_step_s);
/// Rows of a vibration, between whole periods.
inline constexpr long rows_of_vibration = 50;
/// Whether grains are at rest between two taps is asked with so many times the energy.
inline constexpr double tap_rest_factor = 100.0;
/// Of a plate that is laid on the bed, and of one that moves down.
[[nodiscard]] double plate_mass_kg(const ProtocolStep& step, const vessels::Container& container, double gravity_m_per_s2);
[[nodiscard]] double plate_speed_m_per_s(const ProtocolStep& step, double diameter_m, double gravity_m_per_s2);

/// Porosity of the automatic section, of a low bed of its middle half; in a box without walls of the whole box.
struct BedState {
    double height_m = 0.0, porosity = 0.0;
};
[[nodiscard]] BedState bed_state(const packing::Packing& packing, double feret_diameter_m);

}  // namespace porepack::pouring
