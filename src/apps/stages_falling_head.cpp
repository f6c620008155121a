// The falling-head test, simulated and analysed.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "permeability/causes.hpp"
#include "permeability/falling_head.hpp"
#include "permeability/fit.hpp"
#include "permeability/paper_evaluation.hpp"
#include "report/report.hpp"

namespace porepack {
namespace {

constexpr std::size_t most_rows = 20000;

Json number_or_text(double value) {
    return std::isfinite(value) ? Json(value) : Json(value > 0.0 ? "infinite" : "minus infinite");
}

// When the full equation passes a level: between the frames, by bisection.
double time_at(const Column& column, const Resistance& resistance, double start_level_m, double level_m, double guess_s) {
    const auto level = [&](double time) { return column.levels(resistance, 0.0, start_level_m, 0.0, std::vector<double>{time})[0]; };
    double low = 0.0, high = guess_s;
    for (int i = 0; level(high) > level_m; ++i, high *= 2.0)
        if (i == 60) return std::numeric_limits<double>::infinity();
    while (high - low > 1e-9 * high) {
        const double middle = 0.5 * (low + high);
        (level(middle) > level_m ? low : high) = middle;
    }
    return high;
}

}  // namespace

Json falling_head_stage(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config, const Path* folder) {
    const FallingHead test(permeability_m2, inertial_permeability_m, config);
    const Column column(config);
    const Resistance resistance{1.0 / permeability_m2, 1.0 / inertial_permeability_m};
    Json json = {{"permeability_m2", permeability_m2},
                 {"inertial_permeability_m", number_or_text(inertial_permeability_m)},
                 {"sample_length_m", config.sample_length_m},
                 {"start_level_m", config.start_level_m},
                 {"sample_inertia", config.column_inertia ? Json(sample_inertia(config)) : Json(nullptr)},
                 {"levels_m", config.levels_m},
                 {"times_s", Json::array()},
                 {"times_full_equation_s", Json::array()}};
    for (const double level : config.levels_m) {
        const double time = test.time_at(level);
        if (!std::isfinite(time))
            throw UserError(fmt::format("the time at which the level passes {:g} m is beyond all numbers", level),
                            {.mend = "check k, k_in, the viscosity and gravity: SI units"});
        json["times_s"].push_back(time);
        const double full = time_at(column, resistance, config.start_level_m, level, time + 1e-6);
        json["times_full_equation_s"].push_back(std::isfinite(full) ? Json(full) : Json(nullptr));
    }
    const double speed = test.speed_at(config.start_level_m);
    json["start_speed_m_per_s"] = speed;
    // Water that falls freely from the start level would be no faster than this.
    const double free_fall = std::sqrt(2.0 * config.gravity_m_per_s2 * (config.start_level_m + config.sample_length_m));
    if (speed > free_fall)
        json["warning"] = fmt::format(
            "by Eq. 18 the water would start at {:.3g} m/s, faster than it can fall ({:.3g} m/s): Darcy's law alone does not hold here; "
            "give "
            "an inertial permeability",
            speed, free_fall);
    json["equation"] = "times_s: Eq. 18, closed form; times_full_equation_s: with the water's inertia and the meshes as configured";
    if (folder != nullptr) {
        FallingHeadConfig frames = config;
        const double slowest = column.steady_speed(resistance, 0.9 * std::min(config.window_m[0], config.window_m[1]));
        if (slowest > 0.0)
            frames.frames_per_s =
                std::min(config.frames_per_s, static_cast<double>(most_rows) * slowest / (2.0 * config.start_level_m + 2.0 * slowest));
        const LevelCurve curve = simulate_curve(resistance, frames);
        json["frames_per_s"] = frames.frames_per_s;
        json["noise_m"] = config.noise_m;
        std::string text = "time_s,level_m,level_equation_18_m\n# synthetic: computed by porepack falling-head, no measurement\n";
        for (std::size_t i = 0; i < curve.time_s.size(); ++i)
            text += fmt::format("{:.8g},{:.8g},{:.8g}\n", curve.time_s[i], curve.level_m[i], std::max(0.0, test.level_at(curve.time_s[i])));
        write_text(*folder / "falling_head.csv", text);
    }
    return json;
}

// ---- analysis

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
            {"permeability_interval_m2", {number_or_text(k.low), number_or_text(k.high)}},
            {"inverse_permeability_per_m2", a.value},
            {"inverse_permeability_interval_per_m2", {number_or_text(a.interval.low), number_or_text(a.interval.high)}},
            {"inertial_permeability_m", b.value > 0.0 ? Json(1.0 / b.value) : Json(nullptr)},
            {"inverse_inertial_permeability_interval_per_m", {number_or_text(b.interval.low), number_or_text(b.interval.high)}},
            {"correlation", fit.correlation},
            {"viscous_share_of_head", fit.viscous_share},
            {"level_offset_m", fit.level_offset_m},
            {"residual_m", fit.residual_m},
            {"noise_m", fit.noise_m},
            {"points", fit.points},
            {"verdict", doubt + fit.verdict()},
            {"verdict_inertial", doubt + fit.inertial_verdict()}};
}

struct PackingCurves {
    std::vector<LevelCurve> curves;
    std::vector<FallingHeadFit> fits;  ///< of each curve by itself
    bool doubtful = false;
};
using Packings = std::map<std::string, PackingCurves>;

// Mean over the packings, and standard deviations of the curves within a packing and of the packings' means. Of 1/k and 1/k_in, for it is
// these that errors are added to.
Json scatter_json(const Packings& packings, double (*of)(const FallingHeadFit&)) {
    double within = 0.0, all_mean = 0.0;
    std::size_t curves = 0;
    std::vector<double> means;
    for (const auto& [name, packing] : packings) {
        double mean = 0.0;
        for (const FallingHeadFit& fit : packing.fits) mean += of(fit) / static_cast<double>(packing.fits.size());
        for (const FallingHeadFit& fit : packing.fits) within += std::pow(of(fit) - mean, 2);
        curves += packing.fits.size();
        means.push_back(mean);
        all_mean += mean / static_cast<double>(packings.size());
    }
    double between = 0.0;
    for (const double mean : means) between += std::pow(mean - all_mean, 2);
    const std::size_t freedom = curves - packings.size();
    return {{"mean", all_mean},
            {"within_packings", freedom > 0 ? Json(std::sqrt(within / static_cast<double>(freedom))) : Json(nullptr)},
            {"between_packings", means.size() > 1 ? Json(std::sqrt(between / static_cast<double>(means.size() - 1))) : Json(nullptr)}};
}

void draw_analysis(const Path& folder, std::size_t curves, std::size_t points) {
    draw_plot(
        folder / "analysis.svg",
        "set terminal svg size 700,600 font 'DejaVu Sans,12' background 'white'\nset output 'analysis.svg'\nset datafile separator ','\n"
        "set multiplot layout 2,1\nset grid\nset key off\nset xlabel 'time / s'\nset ylabel 'level / m'\n" +
            fmt::format("plot for [i=0:{0}] 'analysis.csv' skip 1 every {1} using ($1==i+1?$2:NaN):3 with points pt 7 ps 0.3 lc i+1, for "
                        "[i=0:{0}] '' skip 1 every {1} using ($1==i+1?$2:NaN):4 with lines lc 'black'\n"
                        "set ylabel 'measured - fitted / mm'\nplot for [i=0:{0}] 'analysis.csv' skip 1 every {1} using "
                        "($1==i+1?$2:NaN):(1e3*$5) with points pt 7 ps 0.3 lc i+1, 0 with lines lc 'black'\nunset multiplot\n",
                        curves - 1, 1 + points / 20000));
}

}  // namespace

Json analyse_stage(const std::vector<Path>& files, const FallingHeadConfig& config, const Path& folder) {
    std::vector<LevelCurve> curves;
    for (const Path& file : files) {
        curves.push_back(take_window(read_level_curve(file), config));
        for (std::size_t c = 0; c + 1 < curves.size(); ++c)
            if (curves[c].time_s == curves.back().time_s && curves[c].level_m == curves.back().level_m)
                throw UserError("the same levels twice: " + curves[c].name + " and " + curves.back().name,
                                {.mend = "leave one out: it would count as a second test"});
    }
    Json json = {{"window_m", config.window_m},
                 {"sample_length_m", config.sample_length_m},
                 {"column_inertia", config.column_inertia},
                 {"sample_inertia", config.column_inertia ? Json(sample_inertia(config)) : Json(nullptr)},
                 {"intervals_hold",
                  "noise, and the level's offset within level_offset_uncertainty_m; sample_length_m, sample_inertia and the meshes are "
                  "taken as given"},
                 {"warnings", Json::array()},
                 {"curves", Json::array()}};
    Packings packings;
    const auto warn = [&](const std::string& warning) {
        log_warning(warning);
        json["warnings"].push_back(warning);
    };
    // A fit that misses the levels by more than their noise cannot be trusted, whatever its interval.
    const auto misses = [&](const FallingHeadFit& fit, const std::string& name) {
        if (fit.residual_m <= 3.0 * std::max(fit.noise_m, 1e-6)) return false;
        warn(fmt::format("{}: the equation misses the levels by {:.2g} mm, their noise is {:.2g} mm: see analysis.svg", name,
                         1e3 * fit.residual_m, 1e3 * fit.noise_m));
        return true;
    };
    for (const LevelCurve& curve : curves) {
        for (const std::string& warning : curve.warnings) warn(warning);
        const FallingHeadFit fit = fit_falling_head(std::span(&curve, 1), config);
        const bool doubtful = misses(fit, curve.name) || curve.doubtful;
        json["curves"].push_back({{"file", curve.name},
                                  {"packing", curve.packing},
                                  {"as_the_paper", paper_json(evaluate_as_paper(curve, config))},
                                  {"least_squares", fit_json(fit, doubtful)}});
        PackingCurves& packing = packings[curve.packing];
        packing.curves.push_back(curve);
        packing.fits.push_back(fit);
        packing.doubtful = packing.doubtful || doubtful;
    }
    double sum = 0.0, squares = 0.0;
    int sound = 0;
    for (const Json& curve : json["curves"])
        if (const Json& k = curve["as_the_paper"]["permeability_m2"]; !k.is_null()) {
            sum += k.get<double>();
            squares += k.get<double>() * k.get<double>();
            ++sound;
        }
    const double mean = sound > 0 ? sum / sound : 0.0;
    json["as_the_paper"] = {
        {"permeability_m2", sound > 0 ? Json(mean) : Json(nullptr)},
        {"standard_deviation_m2", sound > 1 ? Json(std::sqrt(std::max(0.0, squares - sound * mean * mean) / (sound - 1))) : Json(nullptr)},
        {"curves", sound},
        {"curves_without_k", curves.size() - static_cast<std::size_t>(sound)}};
    std::string table = "curve,time_s,level_m,fitted_m,residual_m\n";
    json["packings"] = Json::array();
    std::size_t number = 0, points = 0;
    for (const auto& [name, packing] : packings) {
        const std::vector<LevelCurve>& group = packing.curves;
        const FallingHeadFit fit = group.size() > 1 ? fit_falling_head(group, config) : packing.fits.front();
        const bool doubtful = (group.size() > 1 && misses(fit, "all curves of the packing " + name)) || packing.doubtful;
        json["packings"].push_back({{"packing", name}, {"curves", group.size()}, {"least_squares", fit_json(fit, doubtful)}});
        for (std::size_t c = 0; c < group.size(); ++c) {
            ++number;
            points += group[c].time_s.size();
            for (std::size_t i = 0; i < group[c].time_s.size(); ++i)
                table += fmt::format("{},{:.8g},{:.8g},{:.8g},{:.4g}\n", number, group[c].time_s[i], group[c].level_m[i],
                                     fit.levels_m[c][i], group[c].level_m[i] - fit.levels_m[c][i]);
        }
    }
    json["scatter"] = {
        {"curves", curves.size()},
        {"packings", packings.size()},
        {"inverse_permeability_per_m2",
         scatter_json(packings, [](const FallingHeadFit& f) { return f.inverse_permeability_per_m2.value; })},
        {"inverse_inertial_permeability_per_m",
         scatter_json(packings, [](const FallingHeadFit& f) { return f.inverse_inertial_permeability_per_m.value; })},
        {"meaning",
         "mean over the packings; standard deviations of the fits of single curves within a packing, and of the packings' means"}};
    if (packings.size() == 1) {
        json["verdict"] = json["packings"][0]["least_squares"]["verdict"];
        json["verdict_inertial"] = json["packings"][0]["least_squares"]["verdict_inertial"];
    }
    write_text(folder / "analysis.csv", table);
    draw_analysis(folder, number, points);
    return json;
}

}  // namespace porepack
