// Flows with inertia by both solvers, and the inertial permeability that follows.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "lbm/inertia.hpp"
#include "permeability/forchheimer.hpp"
#include "report/report.hpp"

namespace porepack {
namespace {

// What Reynolds numbers and Ergun's equation are made with.
struct GrainSize {
    double length_m;  ///< of Re
    std::string length_is;
    double sauter_m;  ///< 6 V/A = sphericity times the equal-volume diameter
};

GrainSize grain_size(const Scene& scene) {
    if (!scene.packing) return {1.5 * scene.grain_size_m, "6 volume / area of the surface", 1.5 * scene.grain_size_m};
    const GrainMeans means = grain_means(*scene.packing);
    return {means.equivalent_diameter_m, "diameter of the sphere of the grains' mean volume", means.sauter_diameter_m};
}

double finest_voxel(const Scene& scene, const ForchheimerConfig& config) {
    return config.voxel_size_m > 0.0 ? config.voxel_size_m
           : scene.grains
               ? scene.grain_size_m / 8.0
               : throw UserError("the voxel size is missing", {.mend = "--voxel-size (metres), or voxel_size_m in [forchheimer]"});
}

// Free water before and behind the section, at whose planes the grains are cut off: end planes through grains would differ in their open
// area, and the water would gain momentum between them, or find no steady state.
double water_depth(const Scene& scene) {
    return scene.container.any_periodic() ? 0.0 : 1.5 * scene.grain_size_m;
}

double finest_cell(const Scene& scene, const ForchheimerConfig& config) {
    return config.cell_size_m > 0.0 ? config.cell_size_m : scene.grain_size_m / 4.0;
}

// What OpenFOAM meshes: the grains near the section cut off at its planes, and free water before and behind them.
FoamScene section_in_water(const Scene& scene, const GeometryConfig& geometry, double cell_m) {
    FoamScene foam = foam_scene(scene, geometry, cell_m);
    const double water = water_depth(scene);
    foam.surface = clip_surface(foam.surface, scene.section);
    foam.pore_volume_m3 += 2.0 * water * scene.container.inner_area_m2();
    foam.section = {scene.section.z0 - water, scene.section.z1 + water};
    return foam;
}

Json to_json(const InertialSeries& series) {
    Json json = {{"voxel_size_m", series.voxel_size_m},
                 {"nodes", series.nodes},
                 {"creeping_permeability_m2", series.creeping_permeability_m2},
                 {"peak_over_mean_velocity", series.peak_over_mean},
                 {"stopped_by", series.stopped_by.empty() ? Json(nullptr) : Json(series.stopped_by)},
                 {"flows", Json::array()}};
    for (const InertialFlow& flow : series.flows)
        json["flows"].push_back({{"reynolds", flow.reynolds},
                                 {"permeability_m2", flow.permeability_m2},
                                 {"momentum_share", flow.momentum_share},
                                 {"iteration_error", flow.iteration_error},
                                 {"converged", flow.converged},
                                 {"relaxation_time", flow.relaxation_time},
                                 {"fastest_lattice_velocity", flow.fastest_lu},
                                 {"steps", flow.steps},
                                 {"wall_time_s", flow.seconds}});
    return json;
}

InertialSeries series_from_json(const Json& json) {
    InertialSeries series{.voxel_size_m = json.at("voxel_size_m"),
                          .nodes = json.at("nodes"),
                          .creeping_permeability_m2 = json.at("creeping_permeability_m2"),
                          .peak_over_mean = json.at("peak_over_mean_velocity"),
                          .flows = {},
                          .stopped_by = json.at("stopped_by").is_null() ? "" : json.at("stopped_by").get<std::string>()};
    for (const Json& flow : json.at("flows"))
        series.flows.push_back({.reynolds = flow.at("reynolds"),
                                .permeability_m2 = flow.at("permeability_m2"),
                                .momentum_share = flow.at("momentum_share"),
                                .iteration_error = flow.at("iteration_error"),
                                .converged = flow.at("converged"),
                                .relaxation_time = flow.at("relaxation_time"),
                                .fastest_lu = flow.at("fastest_lattice_velocity"),
                                .steps = flow.at("steps"),
                                .seconds = flow.at("wall_time_s")});
    return series;
}

// Coarse to fine. A grid that a stopped run has finished is read from `folder`.
std::vector<InertialSeries> lattice_series(const Scene& scene, const ForchheimerConfig& config, double length_m, const Path& folder) {
    const LbmScene pores{.voxels =
                             [&](double size) {
                                 return voxelise(scene.solid(), scene.container, scene.section,
                                                 plan_voxels(scene.container, scene.section, size, water_depth(scene), scene.grain_size_m));
                             },
                         .solid = &scene.solid(),
                         .container = scene.container,
                         .section = scene.section};
    ForchheimerConfig copy = config;
    const std::string settings =
        porepack::to_json([&](ConfigVisitor& v) { describe(v, copy); }).dump() + fmt::format("{} {}", scene.section.z0, scene.section.z1);
    std::vector<InertialSeries> all;
    for (long left = config.grids - 1; left >= 0; --left) {
        const Path file = folder / fmt::format("lattice_grid_{}.json", config.grids - left);
        if (std::filesystem::exists(file))
            if (const Json done = read_json(file); done.at("settings") == settings) {
                log_info("flow with inertia: grid {} is done already", config.grids - left);
                all.push_back(series_from_json(done.at("series")));
                continue;
            }
        all.push_back(lbm_inertial_flows(pores, finest_voxel(scene, config) * std::pow(config.grid_ratio, static_cast<double>(left)),
                                         config.reynolds, length_m, {.tolerance = config.tolerance, .max_steps = config.max_steps}));
        write_text(file, Json{{"settings", settings}, {"series", to_json(all.back())}}.dump(2));
    }
    for (long grid = 1; grid <= config.grids; ++grid) std::filesystem::remove(folder / fmt::format("lattice_grid_{}.json", grid));
    return all;
}

std::vector<ApparentPermeability> flows_of(const InertialSeries& series, std::size_t most) {
    std::vector<ApparentPermeability> flows;
    for (const InertialFlow& flow : series.flows)
        if (flows.size() < most) flows.push_back({flow.reynolds, flow.permeability_m2, flow.iteration_error});
    return flows;
}

// What the next coarser grid makes of 1/k_in, from the flows that both have; none with one grid.
std::optional<double> grid_error(const std::vector<InertialSeries>& grids, double length_m) {
    if (grids.size() < 2) return std::nullopt;
    const InertialSeries &fine = grids.back(), &coarse = grids[grids.size() - 2];
    const std::size_t both = std::min(fine.flows.size(), coarse.flows.size());
    if (both < 3) return std::nullopt;
    const double here = fit_forchheimer(fine.creeping_permeability_m2, length_m, flows_of(fine, both)).inertial_permeability_m,
                 there = fit_forchheimer(coarse.creeping_permeability_m2, length_m, flows_of(coarse, both)).inertial_permeability_m;
    return std::abs(here / there - 1.0);
}

Json to_json(const ForchheimerFit& fit) {
    return {{"creeping_permeability_m2", fit.permeability_m2},
            {"intercept_permeability_m2", fit.intercept_permeability_m2},
            {"inertial_permeability_m", fit.inertial_permeability_m},
            {"inertial_permeability_interval_m", list(std::optional(fit.inertial_interval_m))},
            {"inertial_permeability_extrapolated_interval_m", list(std::optional(fit.extrapolated_interval_m))},
            {"inertial_factor", fit.inertial_factor},
            {"onset_reynolds", fit.onset_reynolds ? Json(*fit.onset_reynolds) : Json(nullptr)},
            {"largest_reynolds", fit.largest_reynolds},
            {"points", fit.points}};
}

double number(const Json& json, const char* key) {
    return json.at(key).get<double>();
}

// Rows of forchheimer.csv. OpenFOAM's first flow is the creeping one, by which the others are divided.
std::string curves_table(const Json& json) {
    std::string table = "solver,reynolds,permeability_m2,permeability_over_creeping,relative_error\n";
    const Json& grids = json["lbm"]["grids"];
    for (const Json& grid : grids)
        for (const Json& flow : grid["flows"])
            table +=
                fmt::format("{},{:.5g},{:.6g},{:.5f},{:.2g}\n", &grid == &grids.back() ? "lattice" : "coarser", number(flow, "reynolds"),
                            number(flow, "permeability_m2"), number(flow, "permeability_m2") / number(grid, "creeping_permeability_m2"),
                            number(flow, "iteration_error"));
    if (!json.contains("openfoam")) return table;
    const Json& flows = json["openfoam"]["flows"];
    for (std::size_t i = 1; i < flows.size(); ++i)
        table += fmt::format("openfoam,{:.5g},{:.6g},{:.5f},\n", number(flows[i], "reynolds"), number(flows[i], "permeability_m2"),
                             number(flows[i], "permeability_m2") / number(flows[0], "permeability_m2"));
    return table;
}

void draw_curves(const Path& folder, const Json& json, const ForchheimerFit& fit) {
    const std::string table = curves_table(json);
    write_text(folder / "forchheimer.csv", table);
    std::string plot =
        "set terminal svg size 700,450 font 'DejaVu Sans,12' background 'white'\nset output 'forchheimer.svg'\nset datafile separator ','\n"
        "set grid\nset logscale x\nset xlabel 'Re = U d / nu'\nset ylabel 'k apparent / k'\nset yrange [0:1.1]\nset key left bottom\n" +
        fmt::format("k = {:g}\nd = {:g}\nline(x, k_0, k_in) = 1 / (k / k_0 + k * x / d / k_in)\nplot ", fit.permeability_m2,
                    number(json, "length_m")) +
        fmt::format(
            "line(x, {:g}, {:g}) with lines lc 3 title 'Forchheimer, fitted to the straight part', line(x, k, {:g}) with lines dt 2 lc "
            "'gray40' title \"Ergun's k_{{in}}\", '< grep ^lattice forchheimer.csv' using 2:4:(column(4)*column(5)) with yerrorbars pt 7 "
            "lc 1 title 'lattice Boltzmann'",
            fit.intercept_permeability_m2, fit.inertial_permeability_m, number(json, "ergun_inertial_permeability_m"));
    if (table.find("coarser") != std::string::npos)
        plot += ", '< grep ^coarser forchheimer.csv' using 2:4 with points pt 6 lc 1 title 'its next coarser grid'";
    if (table.find("openfoam") != std::string::npos)
        plot += ", '< grep ^openfoam forchheimer.csv' using 2:4 with points pt 6 ps 1.3 lc 2 title 'OpenFOAM'";
    draw_plot(folder / "forchheimer.svg", plot + "\n");
}

ForchheimerFit fit_lattice(const std::vector<InertialSeries>& grids, double length_m) {
    const InertialSeries& fine = grids.back();
    if (fine.flows.size() < 3)
        throw NumericalError(
            fmt::format("{} steady flows with inertia are too few for the inertial permeability; {}", fine.flows.size(), fine.stopped_by),
            {.allowed = "three or more", .mend = "begin at a smaller Reynolds number, or take smaller voxels"});
    return fit_forchheimer(fine.creeping_permeability_m2, length_m, flows_of(fine, fine.flows.size()),
                           grid_error(grids, length_m).value_or(0.0));
}

Json lattice_part(const std::vector<InertialSeries>& grids, const ForchheimerFit& fit, double length_m) {
    Json part = {{"method", "D3Q19 two relaxation times, full equilibrium, interpolated walls"}, {"grids", Json::array()}};
    for (const auto& grid : grids) part["grids"].push_back(to_json(grid));
    const std::optional<double> error = grid_error(grids, length_m);
    part["creeping_permeability_grid_error"] =
        grids.size() > 1 ? Json(std::abs(grids[grids.size() - 2].creeping_permeability_m2 / fit.permeability_m2 - 1.0)) : Json(nullptr);
    part["stopped_by"] = part["grids"].back()["stopped_by"];
    part.update(to_json(fit));
    part["inertial_permeability_grid_error"] = error ? Json(*error) : Json(nullptr);
    part["interval_meaning"] =
        error ? "slopes of the straight part, of its last two flows, and through creeping flow, with the errors of iteration and grid"
              : "the slopes alone: one grid, so without the error of the grid";
    return part;
}

// Pressure drops over the section that should give the Reynolds numbers asked for, going by the lattice's flows; the first one creeps.
std::vector<double> pressure_drops(const std::vector<double>& reynolds, const InertialSeries& lattice, const ForchheimerFit& fit,
                                   double section_m, double length_m) {
    const double nu = water_viscosity_m2_per_s;
    std::vector<double> drops = {nu * nu / length_m * 0.01 * section_m / fit.permeability_m2};
    for (std::size_t i = 0; i < reynolds.size(); ++i) {
        const InertialFlow& known = lattice.flows[std::min(i, lattice.flows.size() - 1)];
        const double beyond = i < lattice.flows.size() ? 0.0 : (reynolds[i] - known.reynolds) / length_m / fit.inertial_permeability_m;
        drops.push_back(nu * nu * reynolds[i] / length_m * section_m * (1.0 / known.permeability_m2 + beyond));
    }
    return drops;
}

Json foam_part(const Scene& scene, const GeometryConfig& geometry, const ForchheimerConfig& config, const std::vector<double>& drops,
               double length_m, const Path& folder) {
    const FoamConfig foam{.surface_level = config.surface_level,
                          .relaxation_velocity = config.relaxation_velocity,
                          .relaxation_pressure = config.relaxation_pressure,
                          .residual = config.residual,
                          .max_iterations = config.max_iterations,
                          .processes = config.processes};
    const double cell = finest_cell(scene, config);
    make_folder(folder);
    const FoamInertialSeries series =
        foam_inertial_flows(section_in_water(scene, geometry, cell), foam, cell, drops, home_folder() / "openfoam_cases", folder);
    Json part = {{"method", "OpenFOAM simpleFoam, openfoam_cases/inertial_packing"},
                 {"cell_size_m", cell},
                 {"cells", series.mesh.cells},
                 {"mesh_volume_ratio", series.mesh.mesh_volume_ratio},
                 {"wall_time_s", series.mesh.wall_time_s},
                 {"interval_meaning", "the slopes alone: one mesh, so without the error of the mesh"},
                 {"repeat_by_hand", "cd foam/inertial && ./Allclean && ./Allrun"},
                 {"stopped_by", series.stopped_by.empty() ? Json(nullptr) : Json(series.stopped_by)},
                 {"flows", Json::array()}};
    // OpenFOAM's k is that of section and free water together.
    const double section = scene.section.length(), share = section / (section + 2.0 * water_depth(scene));
    std::vector<ApparentPermeability> flows;
    for (const FoamInertialFlow& flow : series.flows) {
        flows.push_back({flow.superficial_velocity_m_per_s * length_m / water_viscosity_m2_per_s, flow.permeability_m2 * share,
                         10.0 * config.residual});
        part["flows"].push_back({{"reynolds", flows.back().reynolds},
                                 {"permeability_m2", flows.back().permeability_m2},
                                 {"pressure_drop_m2_per_s2", flow.pressure_drop_m2_per_s2},
                                 {"momentum_share", flow.momentum_share},
                                 {"iterations", flow.iterations}});
    }
    if (flows.size() > 3) part.update(to_json(fit_forchheimer(flows[0].permeability_m2, length_m, std::span(flows).subspan(1))));
    return part;
}

}  // namespace

Json forchheimer_stage(const Scene& scene, const GeometryConfig& geometry, const ForchheimerConfig& config, const Path& folder) {
    for (std::size_t i = 1; i < config.reynolds.size(); ++i)
        if (!(config.reynolds[i] > config.reynolds[i - 1]))
            throw UserError("the Reynolds numbers do not rise", {.where = "reynolds", .mend = "sort them, each once"});
    const Expectation expected = expect_forchheimer(scene, config);
    require_memory(expected.memory_bytes, "the flows with inertia", "take a larger voxel size or a shorter section");
    const GrainSize size = grain_size(scene);
    const double pores = porosity(scene.solid(), scene.container, scene.section).value;
    const std::vector<InertialSeries> grids = lattice_series(scene, config, size.length_m, folder);
    const ForchheimerFit fit = fit_lattice(grids, size.length_m);
    Json json = {{"length_m", size.length_m},
                 {"length_is", size.length_is},
                 {"porosity", pores},
                 {"section_m", list(scene.section)},
                 {"free_water_m", water_depth(scene)},
                 {"converged", std::all_of(grids.back().flows.begin(), grids.back().flows.end(),
                                           [](const InertialFlow& flow) { return flow.converged; })},
                 {"ergun_inertial_permeability_m", ergun_inertial_m(1.0, size.sauter_m, pores)},
                 {"lbm", lattice_part(grids, fit, size.length_m)}};
    if (config.openfoam)
        json["openfoam"] =
            foam_part(scene, geometry, config, pressure_drops(config.reynolds, grids.back(), fit, scene.section.length(), size.length_m),
                      size.length_m, folder / "foam");
    json["inertial_permeability_m"] = fit.inertial_permeability_m;
    json["inertial_permeability_interval_m"] = list(std::optional(fit.inertial_interval_m));
    json["interval_meaning"] = json["lbm"]["interval_meaning"];
    json["beyond_largest_reynolds"] = fmt::format(
        "extrapolated: there is no steady flow to compute; the interval is {:.0f} % wider on both sides (turbulent coefficients "
        "differ: Fand et al. 1987)",
        100.0 * turbulent_change);
    json["expected_memory_bytes"] = expected.memory_bytes;
    json["peak_memory_bytes"] = peak_memory_bytes();
    draw_curves(folder, json, fit);
    return json;
}

Expectation expect_forchheimer(const Scene& scene, const ForchheimerConfig& config) {
    const VoxelPlan plan = plan_voxels(scene.container, scene.section, finest_voxel(scene, config), water_depth(scene), scene.grain_size_m);
    const double pores = porosity(scene.solid(), scene.container, scene.section, 4000).value;
    const double cells = static_cast<double>(plan.grid.size()),
                 pore_volume = scene.container.inner_area_m2() * (pores * scene.section.length() + 2.0 * water_depth(scene));
    const double fluid = pore_volume / std::pow(plan.voxel_size_m, 3);
    Expectation expected{.text = fmt::format("{} flows on {} grids, the finest {} x {} x {} voxels of {:.4g} m", config.reynolds.size(),
                                             config.grids, plan.grid.cells[0], plan.grid.cells[1], plan.grid.cells[2], plan.voxel_size_m),
                         .memory_bytes = lbm_memory_bytes(cells, fluid, 8.0) + 32.0 * fluid};
    // Measured: some 4000 steps a flow.
    expected.wall_time_s = static_cast<double>(config.reynolds.size()) * 4000.0 * fluid / (8e6 * thread_count());
    if (config.openfoam) {
        // Measured: 300 iterations a flow of 5 us a cell.
        const double foam_cells = pore_volume / std::pow(finest_cell(scene, config), 3) * std::pow(2.5, config.surface_level);
        expected.memory_bytes = std::max(expected.memory_bytes, 1e8 + 1600.0 * foam_cells);
        expected.wall_time_s +=
            static_cast<double>(config.reynolds.size()) * 300.0 * 5e-6 * foam_cells / static_cast<double>(config.processes);
        expected.text += fmt::format(", and by OpenFOAM on about {:.2g} cells", foam_cells);
    }
    return expected;
}

}  // namespace porepack
