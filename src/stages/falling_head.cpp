// The falling-head test, simulated.
#include "falling_head/falling_head.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "falling_head/causes.hpp"
#include "falling_head/column.hpp"
#include "stages/falling_head.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace permeability;
using namespace falling_head;
using namespace pipeline;
namespace fs = std::filesystem;
namespace {

constexpr double maximum_rows = 20000.0;

// Sphericity and equal-volume diameter: not of an image, nor of a surface of several bodies.
struct GrainForm {
    double sphericity, equal_volume_diameter_m, volume_m3;
};
std::optional<GrainForm> grain_form(const Case& c) {
    if (c.from_image()) return std::nullopt;
    const auto shape = c.result<results::Shape>();
    if (!shape.sphericity) return std::nullopt;
    return GrainForm{*shape.sphericity, *shape.equal_volume_diameter_m, shape.volume_m3};
}

results::Correlations correlations_of(const std::optional<GrainForm>& grain, double pores) {
    if (!grain) return {};
    const double psi = grain->sphericity, d = grain->equal_volume_diameter_m;
    results::Correlations found{.carman_kozeny_150_m2 = carman_kozeny_m2(psi, d, pores, 150.0),
                                .carman_kozeny_180_m2 = carman_kozeny_m2(psi, d, pores, 180.0)};
    if (std::abs(grain->volume_m3 / 7.33e-7 - 1.0) < 0.01) found.paper_fit_m2 = paper_fit_m2(pores);
    return found;
}

results::FallingHead run_case_falling_head(const Case& c, const Path& folder) {
    const auto lbm = c.result<results::Lbm>();
    const double pores = c.result<results::Voxelise>().porosity;
    const InertialPermeability inertial = inertial_permeability(c, pores);
    const bool whole_bed = lbm.permeability_bed_m2.has_value();
    const double k = lbm.permeability_bed_m2.value_or(lbm.permeability.m2);
    results::FallingHead result = simulate_falling_head(k, inertial.value_m, apparatus_of(c), &folder);
    result.permeability_from = whole_bed ? "lbm, the whole bed with its free ends" : "lbm, the section";
    result.inertial_permeability_from = inertial.from;
    result.correlations = correlations_of(grain_form(c), pores);
    return result;
}

}  // namespace

// From the stage with the most reliable value.
InertialPermeability inertial_permeability(const Case& c, double pores) {
    if (c.settings.forchheimer.enabled)
        return {c.result<results::Forchheimer>().inertial_permeability_m,
                "the flows with inertia (lattice Boltzmann), extrapolated to the test's Reynolds numbers"};
    const auto grain = grain_form(c);
    if (!grain) return {std::numeric_limits<double>::infinity(), "none: Darcy's law alone"};
    return {ergun_inertial_m(grain->sphericity, grain->equal_volume_diameter_m, pores), "Ergun"};
}

results::FallingHead simulate_falling_head(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                                           const Path* folder) {
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
    if (folder != nullptr) {
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
        for (std::size_t i = 0; i < curve.time_s.size(); ++i)
            table.add(curve.time_s[i], curve.level_m[i], std::max(0.0, test.level_at(curve.time_s[i])));
        write_text(*folder / "falling_head.csv", table.csv_with_note("synthetic: computed by porepack falling-head, not measured"));
    }
    return result;
}

FallingHeadConfig apparatus_of(const Case& c) {
    FallingHeadConfig config = c.settings.falling_head;
    if (config.inertia_coefficient > 0.0 || !fs::exists(c.stage_folder("voxelise") / "result.json")) return config;
    const double pores = c.result<results::Voxelise>().porosity;
    config.inertia_coefficient = std::pow(pores, -1.5);
    if (c.settings.tortuosity.diffusive && fs::exists(c.stage_folder("tortuosity") / "result.json"))
        if (const auto kinds = c.result<results::Tortuosity>(); kinds.diffusive)
            config.inertia_coefficient = kinds.diffusive->tortuosity_factor / pores;
    return config;
}

std::vector<std::string> falling_head_needs(const Case& c) {
    std::vector<std::string> needs = {"voxelise", "lbm"};
    if (!c.from_image()) needs.insert(needs.begin(), "shape");
    if (c.settings.forchheimer.enabled) needs.emplace_back("forchheimer");
    if (c.settings.tortuosity.diffusive) needs.emplace_back("tortuosity");  // for the inertia coefficient
    return needs;
}

Stage make_falling_head_stage(const Case& c) {
    return {.name = "falling-head",
            .needs = falling_head_needs(c),
            .configuration = c.settings.resolved_tables({"falling_head"}),
            .outputs = {"falling_head.csv"},
            .run = [c](const Path& folder) { return run_case_falling_head(c, folder); }};
}

}  // namespace porepack::stages
