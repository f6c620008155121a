#include "analysis/falling_head/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "falling_head/column.hpp"
#include "falling_head/falling_head.hpp"
#include "permeability/permeability.hpp"

namespace porepack::analysis {
namespace {

constexpr double maximum_rows = 20000.0;
constexpr double paper_volume_m3 = 7.33e-7;  ///< of its grains, for which alone its fit holds

}  // namespace

double estimated_inertia_coefficient(double porosity, std::optional<double> tortuosity_factor) {
    return tortuosity_factor ? *tortuosity_factor / porosity : std::pow(porosity, -1.5);
}

std::optional<GrainForm> grain_form(const results::Shape& shape) {
    if (!shape.sphericity) return std::nullopt;
    return GrainForm{*shape.sphericity, *shape.equal_volume_diameter_m, shape.volume_m3};
}

results::Correlations correlations_of(const std::optional<GrainForm>& grain, double porosity) {
    if (!grain) return {};
    const double psi = grain->sphericity, d = grain->equal_volume_diameter_m;
    results::Correlations found{.carman_kozeny_150_m2 = carman_kozeny_m2(psi, d, porosity, 150.0),
                                .carman_kozeny_180_m2 = carman_kozeny_m2(psi, d, porosity, 180.0)};
    if (std::abs(grain->volume_m3 / paper_volume_m3 - 1.0) < 0.01) found.paper_fit_m2 = paper_fit_m2(porosity);
    return found;
}

Outcome<results::FallingHead> simulate_falling_head(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                                                    bool with_curve) {
    const FallingHead test(permeability_m2, inertial_permeability_m, config);
    const Column column(config);
    const Resistance resistance{1.0 / permeability_m2, 1.0 / inertial_permeability_m};
    results::FallingHead result{
        .permeability_m2 = permeability_m2,
        .inertial_permeability_m = inertial_permeability_m,
        .sample_length_m = config.sample_length_m,
        .start_level_m = config.start_level_m,
        .inertia_coefficient = config.column_inertia ? std::optional(inertia_coefficient(config)) : std::nullopt,
        .levels_m = config.levels_m,
        .equation =
            "times_s: Eq. 18, closed form; times_full_equation_s: with the inertia of the water and the wire screens as configured"};
    for (const double level : config.levels_m) {
        const double time = test.time_at(level);
        if (!std::isfinite(time))
            throw UserError(fmt::format("the time at which the water level passes {:g} m is not finite", level),
                            {.fix = "check k, k_in, the viscosity and gravity: SI units"});
        result.times_s.push_back(time);
        const double full = column.time_at(resistance, config.start_level_m, level, time + 1e-6);
        result.times_full_equation_s.push_back(std::isfinite(full) ? std::optional(full) : std::nullopt);
    }
    const double speed = test.speed_at(config.start_level_m);
    result.start_speed_m_per_s = speed;
    // Water in free fall from the start level would not be faster than this.
    const double free_fall = std::sqrt(2.0 * config.gravity_m_per_s2 * (config.start_level_m + config.sample_length_m));
    if (speed > free_fall)
        result.warning = fmt::format(
            "by Eq. 18 the water would start at {:.3g} m/s, faster than it can fall ({:.3g} m/s): Darcy's law alone does not hold here; "
            "give an inertial permeability",
            speed, free_fall);
    if (!with_curve) return {result};
    FallingHeadConfig frames = config;
    const double slowest = column.steady_speed(resistance, 0.9 * std::min(config.window_m[0], config.window_m[1]));
    if (slowest > 0.0)
        frames.frames_per_s = std::min(config.frames_per_s, maximum_rows * slowest / (2.0 * config.start_level_m + 2.0 * slowest));
    if (frames.frames_per_s < config.frames_per_s)
        log_warning(fmt::format("{:.4g} frames per second are written instead of {:g}: the curve would have more than {:.0f} rows",
                                frames.frames_per_s, config.frames_per_s, static_cast<double>(maximum_rows)));
    const LevelCurve curve = simulate_curve(resistance, frames);
    result.frames_per_s = frames.frames_per_s;
    result.noise_m = config.noise_m;
    Table table({"time_s", "level_m", "level_equation_18_m"});
    table.digits = 8;
    table.note = "synthetic: computed by porepack falling-head, not measured";
    for (std::size_t i = 0; i < curve.time_s.size(); ++i)
        table.add(curve.time_s[i], curve.level_m[i], std::max(0.0, test.level_at(curve.time_s[i])));
    return {result, {.tables = {{"falling_head.csv", table}}}};
}

}  // namespace porepack::analysis
