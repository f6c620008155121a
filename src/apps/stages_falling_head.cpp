// The falling-head test: simulated, analysed, and what makes measured and computed permeabilities differ.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "lbm/known.hpp"
#include "lbm/permeability.hpp"
#include "permeability/causes.hpp"
#include "permeability/falling_head.hpp"
#include "permeability/fit.hpp"
#include "permeability/paper_evaluation.hpp"
#include "report/report.hpp"

namespace porepack {
namespace {

constexpr std::size_t most_rows = 20000;

Json number_or_text(double value) {
    return std::isfinite(value) ? Json(value) : Json("infinite");
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

Json fit_json(const FallingHeadFit& fit) {
    const Interval k = fit.permeability_interval_m2();
    const auto& a = fit.inverse_permeability_per_m2;
    const auto& b = fit.inverse_inertial_permeability_per_m;
    return {{"permeability_m2", fit.permeability_m2() ? Json(*fit.permeability_m2()) : Json(nullptr)},
            {"permeability_interval_m2", {number_or_text(k.low), number_or_text(k.high)}},
            {"inverse_permeability_per_m2", a.value},
            {"inverse_permeability_interval_per_m2", {a.interval.low, a.interval.high}},
            {"inertial_permeability_m", b.value > 0.0 ? Json(1.0 / b.value) : Json(nullptr)},
            {"inverse_inertial_permeability_interval_per_m", {b.interval.low, b.interval.high}},
            {"correlation", fit.correlation},
            {"viscous_share_of_head", fit.viscous_share},
            {"level_offset_m", fit.level_offset_m},
            {"residual_m", fit.residual_m},
            {"noise_m", fit.noise_m},
            {"points", fit.points},
            {"verdict", fit.verdict()},
            {"verdict_inertial", fit.inertial_verdict()}};
}

// Scatter of 1/k: within packings and between their means (it is 1/k that errors are added to).
Json scatter_json(const std::map<std::string, std::vector<double>>& groups) {
    double within = 0.0, all_mean = 0.0;
    std::size_t curves = 0;
    std::vector<double> means;
    for (const auto& [name, values] : groups) {
        double mean = 0.0;
        for (const double value : values) mean += value / static_cast<double>(values.size());
        for (const double value : values) within += (value - mean) * (value - mean);
        curves += values.size();
        means.push_back(mean);
        all_mean += mean / static_cast<double>(groups.size());
    }
    double between = 0.0;
    for (const double mean : means) between += (mean - all_mean) * (mean - all_mean);
    const std::size_t freedom = curves - groups.size();
    return {
        {"curves", curves},
        {"packings", groups.size()},
        {"mean_inverse_permeability_per_m2", all_mean},
        {"within_packings_per_m2", freedom > 0 ? Json(std::sqrt(within / static_cast<double>(freedom))) : Json(nullptr)},
        {"between_packings_per_m2", means.size() > 1 ? Json(std::sqrt(between / static_cast<double>(means.size() - 1))) : Json(nullptr)},
        {"meaning", "standard deviations of 1/k by the fit of each curve"}};
}

void draw_analysis(const Path& folder, std::size_t curves) {
    draw_plot(
        folder / "analysis.svg",
        "set terminal svg size 700,600 font 'DejaVu Sans,12' background 'white'\nset output 'analysis.svg'\nset datafile separator ','\n"
        "set multiplot layout 2,1\nset grid\nset key off\nset xlabel 'time / s'\nset ylabel 'level / m'\n" +
            fmt::format(
                "plot for [i=0:{0}] 'analysis.csv' using ($1==i+1?$2:NaN):3 skip 1 with points pt 7 ps 0.3 lc i+1, for [i=0:{0}] "
                "'' using ($1==i+1?$2:NaN):4 skip 1 with lines lc 'black'\n"
                "set ylabel 'measured - fitted / mm'\nplot for [i=0:{0}] 'analysis.csv' using ($1==i+1?$2:NaN):(1e3*$5) skip 1 with "
                "points pt 7 ps 0.3 lc i+1, 0 with lines lc 'black'\nunset multiplot\n",
                curves - 1));
}

}  // namespace

Json analyse_stage(const std::vector<Path>& files, const FallingHeadConfig& config, const Path& folder) {
    std::vector<LevelCurve> curves;
    for (const Path& file : files) curves.push_back(take_window(read_level_curve(file), config));
    Json json = {{"window_m", config.window_m},
                 {"sample_length_m", config.sample_length_m},
                 {"column_inertia", config.column_inertia},
                 {"warnings", Json::array()},
                 {"curves", Json::array()}};
    std::map<std::string, std::vector<double>> inverses;
    std::map<std::string, std::vector<LevelCurve>> packings;
    for (const LevelCurve& curve : curves) {
        for (const std::string& warning : curve.warnings) {
            log_warning(warning);
            json["warnings"].push_back(warning);
        }
        const FallingHeadFit fit = fit_falling_head(std::span(&curve, 1), config);
        if (fit.residual_m > 3.0 * std::max(fit.noise_m, 1e-6)) {
            const std::string warning =
                fmt::format("{}: the equation misses the levels by {:.2g} mm, their noise is {:.2g} mm: see analysis.svg", curve.name,
                            1e3 * fit.residual_m, 1e3 * fit.noise_m);
            log_warning(warning);
            json["warnings"].push_back(warning);
        }
        json["curves"].push_back({{"file", curve.name},
                                  {"packing", curve.packing},
                                  {"as_the_paper", paper_json(evaluate_as_paper(curve, config))},
                                  {"least_squares", fit_json(fit)}});
        inverses[curve.packing].push_back(fit.inverse_permeability_per_m2.value);
        packings[curve.packing].push_back(curve);
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
    std::size_t number = 0;
    for (const auto& [name, group] : packings) {
        const FallingHeadFit fit = fit_falling_head(group, config);
        json["packings"].push_back({{"packing", name}, {"curves", group.size()}, {"least_squares", fit_json(fit)}});
        for (std::size_t c = 0; c < group.size(); ++c) {
            ++number;
            for (std::size_t i = 0; i < group[c].time_s.size(); ++i)
                table += fmt::format("{},{:.8g},{:.8g},{:.8g},{:.4g}\n", number, group[c].time_s[i], group[c].level_m[i],
                                     fit.levels_m[c][i], group[c].level_m[i] - fit.levels_m[c][i]);
        }
    }
    json["scatter"] = scatter_json(inverses);
    if (packings.size() == 1) {
        json["verdict"] = json["packings"][0]["least_squares"]["verdict"];
        json["verdict_inertial"] = json["packings"][0]["least_squares"]["verdict_inertial"];
    }
    write_text(folder / "analysis.csv", table);
    draw_analysis(folder, number);
    return json;
}

// ---- causes

namespace {

constexpr double paper_voxel_m = 133.33e-6;

// k by the paper's scheme / k by ours, on spheres as wide as the capsules, body-centred, of the packing's porosity, at the paper's voxels.
double paper_scheme_ratio(double capsule_m, double solid_fraction) {
    const KnownFlow spheres = sphere_array(std::min(solid_fraction, 0.67), 1.0, body_centred);
    const double voxel = spheres.diameter_m * paper_voxel_m / capsule_m;
    const LbmConfig paper{.walls = "bounce_back", .collision = "bgk", .relaxation_time = 0.59, .iteration_tolerance = 2e-3, .grids = 1};
    const LbmConfig ours{.iteration_tolerance = 1e-3, .grids = 1};
    return lbm_permeability(spheres.scene(), voxel, paper, false).permeability_m2 /
           lbm_permeability(spheres.scene(), voxel, ours, false).permeability_m2;
}

// k of the core, a grain's diameter off the wall / k of the whole tube.
double core_ratio(const Scene& scene, const Section& section, double grain_m) {
    const LbmScene pores{.voxels =
                             [&](double size) {
                                 return voxelise(scene.solid(), scene.container, section,
                                                 plan_voxels(scene.container, section, size, 0.0, scene.grain_size_m));
                             },
                         .solid = &scene.solid(),
                         .container = scene.container,
                         .section = section,
                         .grain_size_m = scene.grain_size_m};
    const FlowImage flow = lbm_permeability(pores, scene.grain_size_m / 6.0, {.iteration_tolerance = 1e-3, .grids = 1}, true).flow;
    double all = 0.0, core = 0.0, all_cells = 0.0, core_cells = 0.0;
    const double radius = 0.5 * scene.container.diameter_m;
    for (std::size_t cell = 0; cell < flow.grid.size(); ++cell) {
        const auto at = place_in_grid(flow.grid, cell);
        const double r = std::hypot(flow.grid.centre(0, at[0]), flow.grid.centre(1, at[1]));
        if (r > radius) continue;
        const double speed = flow.velocity_m_per_s[3 * cell + 2];
        all += speed;
        all_cells += 1.0;
        if (r < radius - grain_m) {
            core += speed;
            core_cells += 1.0;
        }
    }
    return core / core_cells / (all / all_cells);
}

std::string cause_row(const Cause& cause) {
    return fmt::format("\"{}\",\"{}\",{},{},{},\"{}\"\n", cause.name, cause.what, cause.factor ? fmt::format("{:.4g}", *cause.factor) : "",
                       cause.factor ? fmt::format("{:.4g}", cause.low) : "", cause.factor ? fmt::format("{:.4g}", cause.high) : "",
                       cause.note);
}

Json cause_json(const Cause& cause) {
    return {{"cause", cause.name},
            {"what", cause.what},
            {"factor", cause.factor ? Json(*cause.factor) : Json(nullptr)},
            {"range", cause.factor ? Json({cause.low, cause.high}) : Json(nullptr)},
            {"note", cause.note}};
}

void draw_causes(const Path& folder, const std::vector<Cause>& causes, double wanted) {
    std::string rows, labels;
    int row = 0;
    for (auto cause = causes.rbegin(); cause != causes.rend(); ++cause) {
        if (!cause->factor) continue;
        rows += fmt::format("{} {:g} {:g} {:g}\n", row, *cause->factor, cause->low, cause->high);
        std::string label = cause->name + ": " + cause->what;
        for (std::size_t at = 0; (at = label.find('\'', at)) != std::string::npos; at += 2) label.insert(at, "'");
        labels += fmt::format("{}'{}' {}", labels.empty() ? "" : ", ", label.size() > 66 ? label.substr(0, 64) + ".." : label, row);
        ++row;
    }
    write_text(folder / "causes.dat", rows);
    std::string plot = fmt::format(
        "set terminal svg size 1000,{} font 'DejaVu Sans,11' background 'white'\nset output 'causes.svg'\nset grid x\nset logscale x 2\n"
        "set xlabel 'k true / k by the paper''s evaluation'\nset yrange [-0.7:{}]\nset ytics ({})\nset lmargin 58\nset key bottom right\n"
        "set style fill solid 0.5\nset arrow from 1, graph 0 to 1, graph 1 nohead lc 'black'\n",
        90 + 22 * row, row - 0.3, labels);
    if (wanted > 0.0)
        plot += fmt::format(
            "set arrow from {0:g}, graph 0 to {0:g}, graph 1 nohead lw 2 lc rgb '#c04020'\nset label ' to explain: {0:g}' at {0:g}, "
            "graph 0.02 left textcolor rgb '#c04020'\n",
            wanted);
    plot += "plot 'causes.dat' using 2:1:3:4 with xerrorbars pt 7 lc rgb '#205080' notitle\n";
    draw_plot(folder / "causes.svg", plot);
}

// How far each effect moves the level from Eq. 18.
void draw_effects(const Path& folder, const Resistance& sample, const FallingHeadConfig& config) {
    FallingHeadConfig bare = config;
    bare.column_inertia = false;
    bare.mesh_opening_m = bare.mesh_wire_m = bare.level_offset_m = bare.noise_m = bare.loss_coefficient = 0.0;
    std::vector<std::pair<std::string, FallingHeadConfig>> effects = {{"Eq. 18", bare}};
    FallingHeadConfig inertia = bare, meshes = bare, offset = bare;
    inertia.column_inertia = true;
    offset.level_offset_m = 2e-3;
    effects.emplace_back("inertia of the water", inertia);
    if (config.mesh_opening_m > 0.0) {
        meshes.mesh_opening_m = config.mesh_opening_m;
        meshes.mesh_wire_m = config.mesh_wire_m;
        effects.emplace_back("meshes", meshes);
    }
    effects.emplace_back("true level + 2 mm", offset);
    std::vector<std::vector<double>> levels;
    const LevelCurve times = simulate_curve(sample, inertia);
    std::string header = "time_s", text;
    for (auto& [name, effect] : effects) {
        const Column column(effect);
        levels.push_back(column.levels(sample, 0.0, config.start_level_m, 0.0, times.time_s));
        header += "," + name;
    }
    for (std::size_t i = 0; i < times.time_s.size(); ++i) {
        text += fmt::format("{:.6g}", times.time_s[i]);
        for (const auto& level : levels) text += fmt::format(",{:.8g}", level[i]);
        text += "\n";
    }
    write_text(folder / "effects.csv", header + "\n" + text);
    const auto columns = effects.size() + 1;
    draw_plot(
        folder / "effects.svg",
        "set terminal svg size 900,400 font 'DejaVu Sans,12' background 'white'\nset output 'effects.svg'\nset datafile separator ','\n"
        "set multiplot layout 1,2\nset grid\nset xlabel 'time / s'\nset ylabel 'level / m'\nset key right top\n" +
            fmt::format(
                "plot for [i=2:{0}] 'effects.csv' using 1:i with lines lw 2 title columnheader(i)\n"
                "set ylabel 'level less that of Eq. 18 / mm'\nplot for [i=3:{0}] 'effects.csv' using 1:(1e3*(column(i)-$2)) with lines lw "
                "2 lc i-1 title columnheader(i)\nunset multiplot\n",
                columns));
}

}  // namespace

Json causes_stage(const Scene& scene, double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                  const Path& folder) {
    if (scene.container.kind != Container::Kind::cylinder || !scene.packing)
        throw UserError("the causes are those of a packing in a tube", {.where = "[falling_head] causes", .mend = "causes = false"});
    if (scene.bed_top_m < config.sample_length_m)
        throw UserError(fmt::format("the bed is {:g} m high, the sample {:g} m", scene.bed_top_m, config.sample_length_m),
                        {.where = "sample_length_m", .mend = "pour more grains, or shorten the sample"});
    double volume = 0.0;
    for (const Shape& shape : scene.packing->shapes)
        volume += measure(shape, 1e-5).volume_m3 / static_cast<double>(scene.packing->shapes.size());
    const double grain = std::cbrt(6.0 * volume / 3.141592653589793);
    // The sample stands on the floor; its layers are half a grain's diameter high.
    const double central = porosity(scene.solid(), scene.container, scene.section).value;
    const auto count = static_cast<std::size_t>(std::max(2L, std::lround(config.sample_length_m / (0.5 * grain))));
    std::vector<double> layers;
    for (std::size_t i = 0; i < count; ++i) {
        const double height = config.sample_length_m / static_cast<double>(count);
        layers.push_back(
            porosity(scene.solid(), scene.container, {height * static_cast<double>(i), height * static_cast<double>(i + 1)}, 4000).value);
    }
    const ProfileFactors ends = profile_factors(layers, central);
    const ProfileFactors dense = profile_factors({std::max(0.1, central - 0.1)}, central);
    const double share = std::min(1.0, grain / config.sample_length_m);
    const SampleTruth truth{.permeability_m2 = permeability_m2,
                            .inertial_permeability_m = inertial_permeability_m,
                            .ends_viscous = ends.viscous,
                            .ends_inertial = ends.inertial,
                            .aligned_viscous = 1.0 + share * (dense.viscous - 1.0),
                            .aligned_inertial = 1.0 + share * (dense.inertial - 1.0)};
    log_info("causes: simulated tests, evaluated as in the paper");
    CauseStudy study = study_causes(truth, config, config.computed_over_measured);
    log_info("causes: the paper's lattice Boltzmann scheme, and the wall");
    const double scheme = paper_scheme_ratio(scene.grain_size_m, 1.0 - central);
    study.causes.push_back(
        {.name = "the paper's LBM scheme",
         .what = fmt::format("its k / ours: spheres as wide as the capsules, {:.0f} voxels", scene.grain_size_m / paper_voxel_m),
         .factor = scheme,
         .low = scheme,
         .high = scheme});
    const double middle = 0.5 * (scene.section.z0 + scene.section.z1), half = std::min(1.5 * grain, 0.5 * scene.section.length());
    const double core = core_ratio(scene, {middle - half, middle + half}, grain);
    study.causes.push_back({.name = "the wall",
                            .what = "k of the core / k of the tube, had the computation left the wall out",
                            .factor = core,
                            .low = core,
                            .high = core});
    std::string table = "cause,what,factor,low,high,note\n";
    Json json = {{"permeability_m2", permeability_m2},
                 {"inertial_permeability_m", inertial_permeability_m},
                 {"porosity_central", central},
                 {"porosity_layers", layers},
                 {"viscous_share_of_head", study.viscous_share},
                 {"to_explain", config.computed_over_measured > 0.0 ? Json(config.computed_over_measured) : Json(nullptr)},
                 {"factor_is", "k true / k that the paper's evaluation gives; of the two last causes what they would do to k computed"},
                 {"causes", Json::array()},
                 {"together", Json::array()}};
    std::vector<Cause> all = study.causes;
    for (const Cause& cause : study.causes) json["causes"].push_back(cause_json(cause));
    for (const Cause& cause : study.together) {
        json["together"].push_back(cause_json(cause));
        all.push_back(cause);
    }
    for (const Cause& cause : all) table += cause_row(cause);
    const auto offset = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
    json["level_offset_that_explains_alone_m"] = offset(study.explaining_offset_m);
    json["level_offset_that_explains_with_all_m"] = offset(study.explaining_offset_with_all_m);
    write_text(folder / "causes.csv", table);
    draw_causes(folder, all, config.computed_over_measured);
    draw_effects(folder, {1.0 / permeability_m2, 1.0 / inertial_permeability_m}, config);
    return json;
}

}  // namespace porepack
