// What makes measured and computed permeabilities differ: each cause with its factor, in tables and figures.
#include <fmt/format.h>

#include <cmath>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "lbm/known.hpp"
#include "lbm/permeability.hpp"
#include "permeability/causes.hpp"
#include "report/report.hpp"

namespace porepack {
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
        labels += fmt::format("{}'{}' {}", labels.empty() ? "" : ", ", label, row);
        ++row;
    }
    write_text(folder / "causes.dat", rows);
    std::string plot = fmt::format(
        "set terminal svg noenhanced size 1200,{} font 'DejaVu Sans,11' background 'white'\nset output 'causes.svg'\nset grid x\nset "
        "logscale x 2\n"
        "set xlabel 'k true / k by the paper''s evaluation'\nset yrange [-0.7:{}]\nset ytics ({})\nset lmargin 88\nset key bottom right\n"
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
    const double grain = grain_means(*scene.packing).equivalent_diameter_m;
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
                            .porosity = central,
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
                 {"sample_inertia", sample_inertia(config)},
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
