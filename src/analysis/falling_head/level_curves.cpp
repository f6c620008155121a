#include "analysis/falling_head/level_curves.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "analysis/uses.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "falling_head/curve_analysis.hpp"

namespace porepack::analysis {
namespace {

results::PaperFit result_of(const PaperEvaluation& paper) {
    const double k_in = paper.inertial_permeability_m;
    return {.permeability_m2 = paper.sound ? std::optional(paper.permeability_m2) : std::nullopt,
            .inertial_permeability_m = std::isfinite(k_in) ? std::optional(k_in) : std::nullopt,
            .permeability_over_time_m2 = {paper.lowest_m2, paper.highest_m2},
            .quadratic = paper.quadratic,
            .quadratic_residual_m = paper.quadratic_residual_m,
            .fault = paper.fault.empty() ? std::nullopt : std::optional(paper.fault)};
}

results::LeastSquaresFit result_of(const FallingHeadFit& fit, bool doubtful) {
    const std::string doubt = doubtful ? "doubtful, see the warnings: " : "";
    const auto& a = fit.inverse_permeability_per_m2;
    const auto& b = fit.inverse_inertial_permeability_per_m;
    return {.permeability_m2 = fit.permeability_m2(),
            .permeability_interval_m2 = fit.permeability_interval_m2(),
            .inverse_permeability_per_m2 = a.value,
            .inverse_permeability_interval_per_m2 = a.interval,
            .inertial_permeability_m = b.value > 0.0 ? std::optional(1.0 / b.value) : std::nullopt,
            .inverse_inertial_permeability_interval_per_m = b.interval,
            .correlation = fit.correlation,
            .viscous_share_of_head = fit.viscous_share,
            .fitted_within_uncertainty = {.level_offset_m = fit.level_offset_m,
                                          .scale_error = fit.scale_error,
                                          .kinematic_viscosity_m2_per_s = fit.kinematic_viscosity_m2_per_s,
                                          .inertia_coefficient = fit.inertia_coefficient,
                                          .inertial_exponent = fit.inertial_exponent},
            .residual_correlation = fit.residual_correlation,
            .intervals_widened = fit.widening,
            .slow_noise_probability = fit.slow_probability,
            .intervals_widened_if_slow = fit.widening * fit.slow_widening,
            .residual_m = fit.residual_m,
            .noise_m = fit.noise_m,
            .points = fit.points,
            .verdict = doubt + fit.verdict(),
            .verdict_inertial = doubt + fit.inertial_verdict()};
}

results::ScatterOfFits result_of(const Scatter& scatter) {
    return {.mean = scatter.mean, .within_packings = scatter.within_packings, .between_packings = scatter.between_packings};
}

// Measured and fitted water levels, packing by packing; the curves are numbered in this order.
Table levels_table(const FallingHeadAnalysis& analysis) {
    Table table({"curve", "time_s", "level_m", "fitted_m", "residual_m"});
    table.digits = 8;
    std::size_t number = 0;
    for (const PackingAnalysis& packing : analysis.packings)
        for (std::size_t c = 0; c < packing.curves.size(); ++c) {
            const LevelCurve& curve = analysis.curves[packing.curves[c]].curve;
            ++number;
            for (std::size_t i = 0; i < curve.time_s.size(); ++i)
                table.add(number, curve.time_s[i], curve.level_m[i], packing.fit.levels_m[c][i],
                          curve.level_m[i] - packing.fit.levels_m[c][i]);
        }
    return table;
}

}  // namespace

Outcome<results::FallingHeadAnalysis> analyse_level_curves(const std::vector<LevelCurve>& given, const FallingHeadConfig& config) {
    std::vector<LevelCurve> curves;
    for (const LevelCurve& curve : given) {
        curves.push_back(take_window(curve, config));
        if (const std::size_t inside = curves.back().time_s.size(); inside < curve.time_s.size())
            log_info("{}: {} of {} frames lie in the window {:g} to {:g} m", curve.name, inside, curve.time_s.size(), config.window_m[0],
                     config.window_m[1]);
    }
    const FallingHeadAnalysis analysis = analyse_curves(curves, config);
    for (const std::string& warning : analysis.warnings) log_warning(warning);
    results::FallingHeadAnalysis result{
        .window_m = config.window_m,
        .sample_length_m = config.sample_length_m,
        .column_inertia = config.column_inertia,
        .inertia_coefficient = config.column_inertia ? std::optional(inertia_coefficient(config)) : std::nullopt,
        .warnings = analysis.warnings,
        .as_the_paper = {.permeability_m2 = analysis.paper_mean_m2,
                         .standard_deviation_m2 = analysis.paper_deviation_m2,
                         .curves = analysis.curves_with_paper_k,
                         .curves_without_k = analysis.curves.size() - analysis.curves_with_paper_k},
        .scatter = {.curves = analysis.curves.size(),
                    .packings = analysis.packings.size(),
                    .inverse_permeability_per_m2 = result_of(analysis.inverse_permeability_per_m2),
                    .inverse_inertial_permeability_per_m = result_of(analysis.inverse_inertial_permeability_per_m)}};
    for (const CurveAnalysis& one : analysis.curves)
        result.curves.push_back({one.curve.name, one.curve.packing, result_of(one.as_paper), result_of(one.fit, one.doubtful)});
    for (const PackingAnalysis& packing : analysis.packings)
        result.packings.push_back({packing.packing, packing.curves.size(), result_of(packing.fit, packing.doubtful)});
    if (result.packings.size() == 1) {
        result.verdict = result.packings[0].least_squares.verdict;
        result.verdict_inertial = result.packings[0].least_squares.verdict_inertial;
    }
    const Table levels = levels_table(analysis);
    return {result,
            {.tables = {{"analysis.csv", levels}},
             .plots = {
                 {"analysis.svg",
                  "analysis",
                  {{"curves", static_cast<double>(analysis.curves.size())}, {"every_nth", static_cast<double>(1 + levels.rows() / 20000)}},
                  {.width = 700, .height = 600}}}}};
}

}  // namespace porepack::analysis
