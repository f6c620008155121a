// The steps of [protocol] with the built-in DEM.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "pouring/dem/capsule_dem.hpp"
#include "pouring/pour.hpp"
#include "pouring/protocol.hpp"

namespace porepack::pouring::dem {

/// Properties of the grains and of the pour that steps need.
struct ProtocolScale {
    PourPlan plan;
    double diameter_m = 0.0;        ///< smallest, or the smallest thickness
    double feret_diameter_m = 0.0;  ///< largest
    double rest_limit_J = 0.0;  ///< kinetic energy per grain at rest
};

/// Carries the steps out one after another, each in parts, between which the whole state can be saved. A vessel that moves is described
/// in its own frame, in which gravity changes with time. References are kept.
class ProtocolRun {
public:
    ProtocolRun(const ProtocolConfig& protocol, const PackingConfig& config, const ProtocolScale& scale, CapsuleDem& dem);

    /// A row for the bed as poured.
    void begin();
    [[nodiscard]] bool done() const { return at_.step == protocol_.step.size(); }
    /// At most 500 time steps. Throws NumericalError where the bed does not come to rest.
    void advance();
    [[nodiscard]] const std::vector<ProtocolRow>& rows() const { return rows_; }
    /// "tap 3 of 100, porosity 0.412".
    [[nodiscard]] std::string text() const;
    /// Of all steps, roughly.
    [[nodiscard]] double fraction_done() const;
    /// A lid that is still there has come to rest; true without one.
    [[nodiscard]] bool lid_at_rest() const;

    void save(std::ostream& out) const;
    /// Returns false when the data are incomplete.
    [[nodiscard]] bool load(std::istream& in);

private:
    static constexpr long checked_steps = 500;  ///< time steps between two checks
    enum class Phase { begin, move, rest };
    struct At {
        std::size_t step = 0;
        Phase phase = Phase::begin;
        long repeat = 0;
        long since = 0;     ///< time step at which the phase began
        long measured = 0;  ///< rows of a vibration
        double friction = 0.0;
        bool reached = false;
    };

    [[nodiscard]] const ProtocolStep& step() const { return protocol_.step[at_.step]; }
    [[nodiscard]] bool begun() const { return !rows_.empty() || at_.step > 0 || at_.phase != Phase::begin; }
    [[nodiscard]] bool in_box() const;
    [[nodiscard]] long steps_in_phase() const { return dem_.steps() - at_.since; }
    void enter(Phase phase);
    void finish_step();
    /// Time steps of one period of the vessel's motion.
    [[nodiscard]] long period() const;
    void shake(long until);
    void warn_of_soft_grains() const;
    void tap();
    void vibrate();
    void lay_lid();
    void press_down();
    struct Pace {  ///< of a periodic box that shrinks
        double pressure_Pa, fastest_per_s, slowest_per_s;
    };
    [[nodiscard]] Pace pace() const;
    void shrink();
    void shrink_to_pressure();
    void shrink_to_porosity();
    void rest_in_box();
    [[nodiscard]] bool still_in_box() const;
    void rest_after();
    [[nodiscard]] bool at_rest(double factor, bool balanced) const;
    void require_time(const char* what) const;
    void measure(bool reached);
    void change_friction();

    const ProtocolConfig& protocol_;
    const PackingConfig& config_;
    ProtocolScale scale_;
    CapsuleDem& dem_;
    double dt_;
    At at_;
    std::vector<ProtocolRow> rows_;
};

}  // namespace porepack::pouring::dem
