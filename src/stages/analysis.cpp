// Measured falling-head curves: tables, figure, verdicts.
#include "falling_head/analysis.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/log.hpp"
#include "core/table.hpp"
#include "report/plot.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace lbm;
using namespace falling_head;
using namespace report;
namespace {

Json paper_json(const PaperEvaluation& paper) {
    return {{"permeability_m2", paper.sound ? Json(paper.permeability_m2) : Json(nullptr)},
            {"inertial_permeability_m", std::isfinite(paper.inertial_permeability_m) ? Json(paper.inertial_permeability_m) : Json(nullptr)},
            {"permeability_over_time_m2", {paper.lowest_m2, paper.highest_m2}},
            {"quadratic", paper.quadratic},
            {"quadratic_residual_m", paper.quadratic_residual_m},
            {"uncertainty", nullptr},
            {"fault", paper.fault.empty() ? Json(nullptr) : Json(paper.fault)}};
}

Json fit_json(const FallingHeadFit& fit, bool doubtful) {
    const std::string doubt = doubtful ? "doubtful, see the warnings: " : "";
    const Interval k = fit.permeability_interval_m2();
    const auto& a = fit.inverse_permeability_per_m2;
    const auto& b = fit.inverse_inertial_permeability_per_m;
    return {{"permeability_m2", fit.permeability_m2() ? Json(*fit.permeability_m2()) : Json(nullptr)},
            {"permeability_interval_m2", {number_or_null(k.low), number_or_null(k.high)}},
            {"inverse_permeability_per_m2", a.value},
            {"inverse_permeability_interval_per_m2", {number_or_null(a.interval.low), number_or_null(a.interval.high)}},
            {"inertial_permeability_m", b.value > 0.0 ? Json(1.0 / b.value) : Json(nullptr)},
            {"inverse_inertial_permeability_interval_per_m", {number_or_null(b.interval.low), number_or_null(b.interval.high)}},
            {"correlation", fit.correlation},
            {"viscous_share_of_head", fit.viscous_share},
            {"fitted_within_uncertainty",
             {{"level_offset_m", fit.level_offset_m},
              {"scale_error", fit.scale_error},
              {"kinematic_viscosity_m2_per_s", fit.kinematic_viscosity_m2_per_s},
              {"inertia_coefficient", fit.inertia_coefficient},
              {"inertial_exponent", fit.inertial_exponent}}},
            {"residual_correlation", fit.residual_correlation},
            {"intervals_widened", fit.widening},
            {"slow_noise_probability", fit.slow_probability},
            {"intervals_widened_if_slow", fit.widening * fit.slow_widening},
            {"residual_m", fit.residual_m},
            {"noise_m", fit.noise_m},
            {"points", fit.points},
            {"verdict", doubt + fit.verdict()},
            {"verdict_inertial", doubt + fit.inertial_verdict()}};
}

Json scatter_json(const Scatter& scatter) {
    return {{"mean", scatter.mean},
            {"within_packings", json_of(scatter.within_packings)},
            {"between_packings", json_of(scatter.between_packings)}};
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

Json analyse_falling_head(const std::vector<Path>& files, const FallingHeadConfig& config, const Path& folder) {
    std::vector<LevelCurve> curves;
    for (const Path& file : files) {
        const LevelCurve curve = read_level_curve(file);
        curves.push_back(take_window(curve, config));
        if (const std::size_t inside = curves.back().time_s.size(); inside < curve.time_s.size())
            log_info("{}: {} of {} frames lie in the window {:g} to {:g} m", curve.name, inside, curve.time_s.size(), config.window_m[0],
                     config.window_m[1]);
    }
    const FallingHeadAnalysis analysis = analyse_curves(curves, config);
    for (const std::string& warning : analysis.warnings) log_warning(warning);
    Json json = {
        {"window_m", config.window_m},
        {"sample_length_m", config.sample_length_m},
        {"column_inertia", config.column_inertia},
        {"inertia_coefficient", config.column_inertia ? Json(inertia_coefficient(config)) : Json(nullptr)},
        {"intervals_hold",
         "noise (with its correlation between frames), and what has an uncertainty: level offset, scale, viscosity, inertia coefficient, "
         "inertial exponent; sample_length_m and the screens are taken as given"},
        {"warnings", analysis.warnings},
        {"curves", Json::array()}};
    keep_old_name(json, "sample_inertia", "inertia_coefficient");
    for (const CurveAnalysis& one : analysis.curves)
        json["curves"].push_back({{"file", one.curve.name},
                                  {"packing", one.curve.packing},
                                  {"as_the_paper", paper_json(one.as_paper)},
                                  {"least_squares", fit_json(one.fit, one.doubtful)}});
    json["as_the_paper"] = {{"permeability_m2", json_of(analysis.paper_mean_m2)},
                            {"standard_deviation_m2", json_of(analysis.paper_deviation_m2)},
                            {"curves", analysis.curves_with_paper_k},
                            {"curves_without_k", analysis.curves.size() - analysis.curves_with_paper_k}};
    json["packings"] = Json::array();
    for (const PackingAnalysis& packing : analysis.packings)
        json["packings"].push_back(
            {{"packing", packing.packing}, {"curves", packing.curves.size()}, {"least_squares", fit_json(packing.fit, packing.doubtful)}});
    json["scatter"] = {
        {"curves", analysis.curves.size()},
        {"packings", analysis.packings.size()},
        {"inverse_permeability_per_m2", scatter_json(analysis.inverse_permeability_per_m2)},
        {"inverse_inertial_permeability_per_m", scatter_json(analysis.inverse_inertial_permeability_per_m)},
        {"meaning",
         "mean over the packings; standard deviations of the fits of single curves within a packing, and of the packings' means"}};
    if (analysis.packings.size() == 1)
        for (const char* key : {"verdict", "verdict_inertial"}) json[key] = json["packings"][0]["least_squares"][key];
    const Table levels = levels_table(analysis);
    levels.write(folder / "analysis.csv");
    draw_plot(folder / "analysis.svg", "analysis",
              {{"curves", static_cast<double>(analysis.curves.size())}, {"every_nth", static_cast<double>(1 + levels.rows() / 20000)}},
              {.width = 700, .height = 600});
    return json;
}

}  // namespace porepack::stages
