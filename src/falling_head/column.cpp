#include "falling_head/column.hpp"

#include <boost/math/tools/roots.hpp>
#include <limits>

#include <fmt/format.h>
#include <boost/numeric/odeint.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"

namespace porepack::falling_head {
namespace {

constexpr double max_settling_times = 2e4;
constexpr long max_steps = 100000;

double correction(double reynolds) {
    constexpr std::array<double, 8> re = {50, 100, 150, 200, 300, 400, 500, 1000}, k = {1.44, 1.24, 1.13, 1.08, 1.03, 1.01, 1.01, 1.0};
    if (reynolds <= re.front()) return k.front();
    if (reynolds >= re.back()) return k.back();
    std::size_t i = 1;
    while (re[i] < reynolds) ++i;
    const double part = std::log(reynolds / re[i - 1]) / std::log(re[i] / re[i - 1]);
    return k[i - 1] + part * (k[i] - k[i - 1]);
}

}  // namespace

double screen_loss(double opening_m, double wire_m, double free_fraction, double speed_m_per_s, double kinematic_viscosity_m2_per_s) {
    const double side = opening_m / (opening_m + wire_m), open = side * side * free_fraction;
    const double quadratic = 1.3 * (1.0 - open) + (1.0 / open - 1.0) * (1.0 / open - 1.0);
    const double reynolds = std::max(1e-9, speed_m_per_s / open * wire_m / kinematic_viscosity_m2_per_s);
    return correction(reynolds) * quadratic + (reynolds < 50.0 ? 22.0 / reynolds - 22.0 / 50.0 : 0.0);
}

Column::Column(const FallingHeadConfig& config)
    : config_(config), offset_(config.level_offset_m), inertia_length_(inertia_coefficient(config) * config.sample_length_m) {
    if (config_.screen_opening_m > 0.0 && config_.screen_wire_m == 0.0) config_.screen_wire_m = 0.2 * config_.screen_opening_m;
    if (config_.screen_opening_m == 0.0 && config_.screen_wire_m > 0.0)
        throw UserError("a wire screen has wires but no openings", {.where = "screen_opening_m", .fix = "give screen_opening_m (metres)"});
    if ((config_.inertial_exponent > 0.0 || config_.inertial_exponent_uncertainty > 0.0) && config_.inertial_reference_speed_m_per_s == 0.0)
        throw UserError("inertial_exponent has no effect without a speed from which k_in falls",
                        {.where = "inertial_exponent", .fix = "give inertial_reference_speed_m_per_s"});
    if (config_.screen_wire_m > 10.0 * config_.screen_opening_m)
        throw UserError(fmt::format("wires of {:g} m and openings of {:g} m leave almost nothing open", config_.screen_wire_m,
                                    config_.screen_opening_m),
                        {.where = "screen_wire_m", .fix = "check the units: metres"});
}

double Column::screen_losses(double speed) const {
    const auto& c = config_;
    double loss = c.loss_coefficient;
    if (c.screen_opening_m > 0.0) {
        const double nu = c.kinematic_viscosity_m2_per_s;
        if (c.screens_below > 0)
            loss +=
                static_cast<double>(c.screens_below) * screen_loss(c.screen_opening_m, c.screen_wire_m, c.screen_free_fraction, speed, nu);
        if (c.screens_above > 0)
            loss += static_cast<double>(c.screens_above) * screen_loss(c.screen_opening_m, c.screen_wire_m, 1.0, speed, nu);
    }
    return loss;
}

double Column::water_level(double measured_m) const {
    return measured_m + offset_ + config_.scale_error * (measured_m - 0.5 * (config_.window_m[0] + config_.window_m[1]));
}

double Column::measured_level(double water_level_m) const {
    const double middle = 0.5 * (config_.window_m[0] + config_.window_m[1]);
    return (water_level_m - offset_ + config_.scale_error * middle) / (1.0 + config_.scale_error);
}

double Column::inertial_factor(double speed) const {
    const double reference = config_.inertial_reference_speed_m_per_s;
    if (config_.inertial_exponent == 0.0 || !(reference > 0.0) || speed <= reference) return 1.0;
    return std::pow(speed / reference, -config_.inertial_exponent);
}

double Column::quadratic_losses(const Resistance& resistance, double speed, double water_level_m) const {
    return config_.sample_length_m * resistance.inverse_inertial_permeability_per_m * inertial_factor(speed) +
           0.5 * (screen_losses(speed) + config_.column_friction_per_m * water_level_m);
}

// m2/s2; odd function of the speed.
double Column::losses(const Resistance& resistance, double speed, double water_level_m) const {
    const double viscous = config_.sample_length_m * config_.kinematic_viscosity_m2_per_s * resistance.inverse_permeability_per_m2;
    return viscous * speed + quadratic_losses(resistance, std::abs(speed), water_level_m) * speed * std::abs(speed);
}

double Column::steady_speed(const Resistance& resistance, double level_m) const {
    return speed_at(resistance, water_level(level_m));
}

double Column::speed_at(const Resistance& resistance, double water_level_m) const {
    const double head = config_.gravity_m_per_s2 * (water_level_m + config_.sample_length_m);
    if (!(head > 0.0)) return 0.0;
    // The coefficients of v^2 depend little on the speed: a quadratic equation for each estimate of them.
    const double linear = config_.sample_length_m * config_.kinematic_viscosity_m2_per_s * resistance.inverse_permeability_per_m2;
    double speed = 0.1;
    for (int i = 0; i < 50; ++i) {
        const double square = quadratic_losses(resistance, speed, water_level_m);
        const double next = 2.0 * head / (linear + std::sqrt(std::max(0.0, linear * linear + 4.0 * square * head)));
        if (std::abs(next - speed) <= 1e-15 * next) return next;
        speed = next;
    }
    return speed;
}

std::vector<double> Column::levels(const Resistance& resistance, double start_s, double level_m, double speed_m_per_s,
                                   std::span<const double> times_s) const {
    namespace ode = boost::numeric::odeint;
    using State = std::array<double, 2>;  // water level (not the measured one), speed
    constexpr double tolerance = 1e-11;
    if (times_s.empty()) return {};
    // If the speed adapts to the level within a small part of the test, inertia is neglected: the equation would be stiff.
    const double damping = config_.kinematic_viscosity_m2_per_s * resistance.inverse_permeability_per_m2 +
                           2.0 * steady_speed(resistance, level_m) * resistance.inverse_inertial_permeability_per_m;
    const double start_level = water_level(level_m);
    const double settling = config_.sample_length_m * damping / (start_level + inertia_length_) * (times_s.back() - start_s);
    const bool inertia = config_.column_inertia && !(settling > max_settling_times);
    const auto rate = [&](const State& x, State& d, double) {
        // A water level that has reached the sample is not computed further.
        if (x[0] <= 0.0) {
            d = {0.0, 0.0};
            return;
        }
        if (!inertia) {
            d = {-speed_at(resistance, x[0]), 0.0};
            return;
        }
        const double head = config_.gravity_m_per_s2 * (x[0] + config_.sample_length_m);
        d = {-x[1], (head - losses(resistance, x[1], x[0])) / (x[0] + inertia_length_)};
    };
    std::vector<double> levels;
    levels.reserve(times_s.size());
    State x = {start_level, inertia ? speed_m_per_s : 0.0};
    auto stepper = ode::make_dense_output(tolerance, tolerance, ode::runge_kutta_dopri5<State>());
    stepper.initialize(x, start_s, 1e-4);
    long steps = 0;
    for (const double time : times_s) {
        while (stepper.current_time() < time) {
            stepper.do_step(rate);
            if (++steps > max_steps || !std::isfinite(stepper.current_state()[0]))
                throw NumericalError(fmt::format("the falling water level could not be computed: 1/k = {:g} 1/m2, 1/k_in = {:g} 1/m",
                                                 resistance.inverse_permeability_per_m2, resistance.inverse_inertial_permeability_per_m),
                                     {.fix = "check k, k_in and the lengths: SI units"});
        }
        if (time <= start_s) {
            levels.push_back(level_m);
            continue;
        }
        stepper.calc_state(time, x);
        levels.push_back(measured_level(x[0]));
    }
    return levels;
}

double Column::time_at(const Resistance& resistance, double start_level_m, double level_m, double guess_s) const {
    const auto above = [&](double time) { return levels(resistance, 0.0, start_level_m, 0.0, std::vector<double>{time})[0] - level_m; };
    if (above(0.0) <= 0.0) return 0.0;
    double high = guess_s;
    for (int i = 0; above(high) > 0.0; ++i, high *= 2.0)
        if (i == 60) return std::numeric_limits<double>::infinity();
    const auto close = [](double a, double b) { return b - a <= 1e-9 * b; };
    return boost::math::tools::bisect([&](double time) { return above(time) > 0.0 ? 1.0 : -1.0; }, 0.0, high, close).second;
}

}  // namespace porepack::falling_head
