#include "analysis/inertia.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/device_use.hpp"
#include "analysis/uses.hpp"
#include "converters/surface.hpp"
#include "core/communicator.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/members_json.hpp"
#include "core/table.hpp"
#include "devices/device.hpp"
#include "lbm/domain.hpp"
#include "lbm/inertia.hpp"
#include "openfoam/foam.hpp"
#include "openfoam/foam_cost.hpp"
#include "permeability/forchheimer.hpp"
#include "permeability/inertial_laws.hpp"
#include "permeability/permeability.hpp"
#include "record/resolved_config.hpp"

namespace porepack::analysis {
namespace {

// The characteristic lengths of the Reynolds number and of Ergun's equation.
struct GrainSize {
    double length_m;  ///< of Re
    std::string length_is;
    double sauter_m;  ///< 6 V/A
};

GrainSize grain_size(const PoreSpace& space) {
    // With menisci, the area of the solid is not that of the grains.
    if (space.closing_radius_m > 0.0)
        return {space.equivalent_diameter_m, "diameter of the sphere of the grains' mean volume", std::numeric_limits<double>::quiet_NaN()};
    if (!space.packing()) return {1.5 * space.grain_size_m, "6 volume / area of the surface", 1.5 * space.grain_size_m};
    const GrainMeans means = grain_means(*space.packing());
    return {means.equivalent_diameter_m, "diameter of the sphere of the grains' mean volume", means.sauter_diameter_m};
}

double finest_voxel(const PoreSpace& space, const ForchheimerConfig& config) {
    if (config.voxel_size_m > 0.0) return config.voxel_size_m;
    if (space.grains() || space.closing_radius_m > 0.0)
        return space.grain_size_m / (config.mean_in_time ? 16.0 : 8.0);  // their walls may become less accurate
    throw UserError("the voxel size is missing", {.fix = "--voxel-size (metres), or voxel_size_m in [forchheimer]"});
}

double finest_cell(const PoreSpace& space, const ForchheimerConfig& config) {
    return config.cell_size_m > 0.0 ? config.cell_size_m : space.grain_size_m / 4.0;
}

// Free water beyond the section and its buffers, where the grains are cut off: end planes through grains would differ in their open area,
// and the water would gain momentum between them, or find no steady state.
double water_depth(const PoreSpace& space) {
    return space.container.periodic()[2] ? 0.0 : 1.5 * space.grain_size_m;
}

// The section in its bed, or alone where the case asks for planes.
PoreSpace without_reservoir(const PoreSpace& given) {
    if (given.ends == Ends::paper)
        log_warning(
            "flows with inertia have free water at the planes of the section, not the ends of the paper: in_situ is nearer to a bed");
    if (given.ends != Ends::in_situ) return given.section_only();
    PoreSpace space = given;
    space.reservoir_m = 0.0;
    return space;
}

Path file_of_grid(const Path& folder, long grid) {
    return folder / fmt::format("lattice_grid_{}.json", grid);
}

// Coarse to fine, by all ranks. A grid that an interrupted run has finished is read from `folder`, by the first.
std::vector<InertialSeries> lattice_series(const PoreSpace& space, const ForchheimerConfig& config, double length_m, const Path& folder) {
    PoreSpace pores = space;
    pores.reservoir_m = water_depth(space);
    const std::string settings = resolved_config(config).dump() + fmt::format("watched for half a turnover {} {} {}", space.section.z0_m,
                                                                              space.section.z1_m, json_of(space.buffers_m).dump());
    const std::shared_ptr<devices::Device> device = config.device == "cpu" ? nullptr : devices::open_device(config.device);
    std::vector<InertialSeries> all;
    for (long grid = 1; grid <= config.grids; ++grid) {
        const Path file = file_of_grid(folder, grid);
        const Json done = ranks().part() == 0 && std::filesystem::exists(file) ? read_json(file) : Json();
        const bool is_done = done.is_object() && done.at("settings") == settings;
        if (any_of(ranks(), is_done)) {
            if (is_done) all.push_back(from_json_members<InertialSeries>(done.at("series")));
            log_info("flow with inertia: grid {} is done already", grid);
            continue;
        }
        const double voxel = finest_voxel(space, config) * std::pow(config.grid_ratio, static_cast<double>(config.grids - grid));
        InertialCriterion criterion{.tolerance = config.tolerance, .max_steps = config.max_steps, .device = device};
        if (config.mean_in_time) criterion.in_time = {.tolerance = config.statistical_tolerance, .max_turnovers = config.max_turnovers};
        all.push_back(lbm_inertial_flows(pores, voxel, config.reynolds, length_m, criterion));
        if (ranks().part() == 0) write_json(file, {{"settings", settings}, {"series", json_of(all.back())}});
    }
    return all;
}

InertialCurve curve_of(const InertialSeries& series) {
    InertialCurve curve{.permeability_m2 = series.creeping_permeability_m2, .flows = {}};
    for (const InertialFlow& flow : series.flows) curve.flows.push_back({flow.reynolds, flow.permeability_m2, flow.error()});
    return curve;
}

// Change of 1/k_in to the next coarser grid; none with one grid.
std::optional<double> grid_error(const std::vector<InertialSeries>& grids, double length_m) {
    if (grids.size() < 2) return std::nullopt;
    return inertial_grid_error(curve_of(grids[grids.size() - 2]), curve_of(grids.back()), length_m);
}

// Of 1/k_in, relative, by the stretch of a periodic box: on arrays of spheres it was at most 2.7 times the largest |factor - 1|.
double stretch_error(const std::vector<InertialSeries>& grids) {
    constexpr double per_strain = 4.0;
    double strain = 0.0;
    for (const InertialSeries& grid : grids) strain = std::max(strain, strain_of(grid.stretch));
    return per_strain * strain;
}

// One standard deviation.
double relative_error(const InertialFlow& flow) {
    return flow.in_time ? std::hypot(flow.error(), 0.5 * flow.in_time->wall_half_width()) : flow.error();
}

// OpenFOAM's first flow is the creeping flow; the others are divided by it.
Table curves_table(const results::Forchheimer& result) {
    Table table({"solver", "reynolds", "permeability_m2", "permeability_over_creeping", "relative_error"});
    table.digits = 6;
    for (const InertialSeries& grid : result.lbm.grids)
        for (const InertialFlow& flow : grid.flows)
            table.add(&grid == &result.lbm.grids.back() ? "lattice" : "coarser", flow.reynolds, flow.permeability_m2,
                      flow.permeability_m2 / grid.creeping_permeability_m2, relative_error(flow));
    if (!result.openfoam) return table;
    const auto& flows = result.openfoam->flows;
    for (std::size_t i = 1; i < flows.size(); ++i)
        table.add("openfoam", flows[i].reynolds, flows[i].permeability_m2, flows[i].permeability_m2 / flows[0].permeability_m2,
                  std::optional<double>());
    return table;
}

Files files_of(const results::Forchheimer& result) {
    const ForchheimerFit& fit = result.lbm.fit;
    return {.tables = {{"forchheimer.csv", curves_table(result)}},
            .plots = {{"forchheimer.svg",
                       "forchheimer",
                       {{"k", fit.permeability_m2},
                        {"d", result.length_m},
                        {"k_intercept", fit.intercept_permeability_m2},
                        {"k_in", fit.inertial_permeability_m},
                        {"k_in_ergun", result.ergun_inertial_permeability_m},
                        {"coarser", result.lbm.grids.size() > 1 ? 1.0 : 0.0},
                        {"openfoam", result.openfoam ? 1.0 : 0.0}},
                       {.width = 700, .height = 450}}}};
}

// Change of 1/k_in if the walls of means in time are off by what their correction is uncertain, all to the same side.
double wall_part(const InertialSeries& series, const ForchheimerFit& fit, double length_m) {
    double change = 0.0;
    for (const double side : {-1.0, 1.0}) {
        InertialCurve curve = curve_of(series);
        for (std::size_t i = 0; i < curve.flows.size(); ++i)
            if (series.flows[i].in_time) curve.flows[i].permeability_m2 *= 1.0 + side * series.flows[i].in_time->wall_half_width();
        try {
            const ForchheimerFit moved = fit_forchheimer(curve.permeability_m2, length_m, curve.flows);
            change = std::max(change, std::abs(fit.inertial_permeability_m / moved.inertial_permeability_m - 1.0));
        } catch (const NumericalError&) {  // k rises with Re: nothing is known of 1/k_in
            change = 1.0;
        }
    }
    return change;
}

ForchheimerFit fit_lattice(const std::vector<InertialSeries>& grids, double length_m) {
    const InertialSeries& fine = grids.back();
    if (fine.flows.size() < 3)
        throw NumericalError(fmt::format("{} flows with inertia are too few for the inertial permeability; {}", fine.flows.size(),
                                         fine.stopped_by.value_or("")),
                             {.allowed = "three or more", .fix = "start at a smaller Reynolds number, or use smaller voxels"});
    const InertialCurve curve = curve_of(fine);
    const ForchheimerFit fit = fit_forchheimer(curve.permeability_m2, length_m, curve.flows);
    const double common = grid_error(grids, length_m).value_or(0.0) + stretch_error(grids) + wall_part(fine, fit, length_m);
    return fit_forchheimer(curve.permeability_m2, length_m, curve.flows, common);
}

std::string method_of(const std::vector<InertialFlow>& flows) {
    if (!flows.front().in_time) return "D3Q19 two relaxation times, full equilibrium, interpolated walls";
    const auto accurate = [](const InertialFlow& flow) { return flow.in_time->wall_error == 0.0; };
    const auto first = std::ranges::find_if_not(flows, accurate);
    const std::string means = "D3Q19, full equilibrium, interpolated walls, means in time; ", other = "recursive regularised collision";
    if (first == flows.begin()) return means + other;
    return means + "two relaxation times" + (first == flows.end() ? "" : fmt::format(", from Re {:.3g} on {}", first->reynolds, other));
}

results::InertiaByLattice lattice_part(const std::vector<InertialSeries>& grids, const ForchheimerFit& fit, double length_m) {
    const InertialSeries &fine = grids.back(), *coarser = grids.size() > 1 ? &grids[grids.size() - 2] : nullptr;
    const bool in_time = fine.flows.front().in_time.has_value();
    const std::optional<double> error = grid_error(grids, length_m);
    return {.method = method_of(fine.flows),
            .grids = grids,
            .creeping_permeability_grid_error =
                coarser != nullptr ? std::optional(std::abs(coarser->creeping_permeability_m2 / fit.permeability_m2 - 1.0)) : std::nullopt,
            .stopped_by = fine.stopped_by,
            .fit = fit,
            .laws = fit_inertial_laws(curve_of(fine), coarser != nullptr ? std::optional(curve_of(*coarser)) : std::nullopt),
            .inertial_permeability_grid_error = error,
            .interval_meaning = fmt::format(
                "slopes of the straight part, of its last two flows, and through creeping flow, with the errors of {}{}{}",
                in_time ? "the means in time and of their walls" : "iteration", stretch_error(grids) > 0.0 ? ", of the stretched box" : "",
                error ? " and of the grid" : "; one grid, so without grid error")};
}

results::InertiaByFoam foam_part(const PoreSpace& space, const GeometryConfig& geometry, const ForchheimerConfig& config,
                                 const std::vector<double>& drops, double length_m, const Path& folder) {
    const FoamConfig foam{.surface_level = config.surface_level,
                          .relaxation_velocity = config.relaxation_velocity,
                          .relaxation_pressure = config.relaxation_pressure,
                          .residual = config.residual,
                          .max_iterations = config.max_iterations,
                          .processes = config.processes};
    const double cell = finest_cell(space, config), water = water_depth(space);
    make_folder(folder);
    const FoamInertialSeries series = foam_inertial_flows(foam_scene_in_water(space, surface_options(geometry), cell, water), foam, cell,
                                                          drops, data_file("openfoam_cases"), folder);
    results::InertiaByFoam part{.method = "OpenFOAM simpleFoam, openfoam_cases/inertial_packing",
                                .cell_size_m = cell,
                                .cells = series.mesh.cells,
                                .mesh_volume_ratio = series.mesh.mesh_volume_ratio,
                                .wall_time_s = series.mesh.wall_time_s,
                                .interval_meaning = "the slopes alone: one mesh, so without mesh error",
                                .repeat_by_hand = "cd foam/inertial && ./Allclean && ./Allrun",
                                .stopped_by = series.stopped_by};
    // Without buffers, OpenFOAM's k is that of the section together with the free water.
    const double section = space.section.length(), share = space.ends == Ends::in_situ ? 1.0 : section / (section + 2.0 * water);
    std::vector<ApparentPermeability> flows;
    for (const FoamInertialFlow& flow : series.flows) {
        flows.push_back({flow.superficial_velocity_m_per_s * length_m / water_viscosity_m2_per_s, flow.permeability_m2 * share,
                         10.0 * config.residual});
        part.flows.push_back({.reynolds = flows.back().reynolds,
                              .permeability_m2 = flows.back().permeability_m2,
                              .pressure_drop_m2_per_s2 = flow.pressure_drop_m2_per_s2,
                              .momentum_share = flow.momentum_share,
                              .iterations = flow.iterations});
    }
    if (flows.size() > 3) {
        part.fit = fit_forchheimer(flows[0].permeability_m2, length_m, std::span(flows).subspan(1));
        part.laws = fit_inertial_laws({flows[0].permeability_m2, {flows.begin() + 1, flows.end()}});
    }
    return part;
}

// Throws UserError for an image, and for keys without effect.
PoreSpace checked_space(const PoreSpace& given, const ForchheimerConfig& config) {
    for (std::size_t i = 1; i < config.reynolds.size(); ++i)
        if (!(config.reynolds[i] > config.reynolds[i - 1]))
            throw UserError("the Reynolds numbers do not rise", {.where = "reynolds", .fix = "sort them, each once"});
    const auto& periodic = given.container.periodic();
    if (config.openfoam && (periodic[0] || periodic[1] || periodic[2]))
        throw UserError("OpenFOAM computes flows with inertia in containers without periodic faces only",
                        {.where = "openfoam in [forchheimer]", .fix = "--openfoam false"});
    if (config.openfoam && given.closing_radius_m > 0.0)
        throw UserError("OpenFOAM's mesh is made from the grains, without menisci",
                        {.where = "openfoam in [forchheimer]", .fix = "--openfoam false"});
    const ForchheimerConfig standard;
    if (!config.mean_in_time &&
        (config.statistical_tolerance != standard.statistical_tolerance || config.max_turnovers != standard.max_turnovers))
        throw UserError("statistical_tolerance and max_turnovers have no effect without mean_in_time",
                        {.where = "[forchheimer]", .fix = "--mean-in-time true, or remove them"});
    PoreSpace space = without_reservoir(given);
    if (!space.has_exact_walls())
        throw UserError("flows with inertia need a packing or an STL file, not an image", {.where = space.source});
    return space;
}

}  // namespace

void solve_lattice_grids(const PoreSpace& space, const ForchheimerConfig& config, const Path& folder) {
    const PoreSpace pores = checked_space(space, config);
    (void)lattice_series(pores, config, grain_size(pores).length_m, folder);
}

Outcome<results::Forchheimer> compute_inertial_flows(const PoreSpace& given, const GeometryConfig& geometry,
                                                     const ForchheimerConfig& config, const Path& folder) {
    const PoreSpace space = checked_space(given, config);
    const Expectation expected = expect_inertia(space, config);
    require_memory(expected.memory_bytes, "the flows with inertia", "use a larger voxel size or a shorter section");
    const GrainSize size = grain_size(space);
    const double pores = space.porosity().value;
    const std::vector<InertialSeries> grids = lattice_series(space, config, size.length_m, folder);
    for (long grid = 1; grid <= config.grids; ++grid) std::filesystem::remove(file_of_grid(folder, grid));
    const ForchheimerFit fit = fit_lattice(grids, size.length_m);
    const auto steady = [](const InertialFlow& flow) { return flow.converged; };
    results::Forchheimer result{
        .length_m = size.length_m,
        .length_is = size.length_is,
        .porosity = pores,
        .section_m = space.section.interval(),
        .ends = std::string(name_of(space.ends)),
        .buffers_m = space.buffers_m,
        .free_water_m = water_depth(space),
        .converged = std::all_of(grids.back().flows.begin(), grids.back().flows.end(), steady),
        .ergun_inertial_permeability_m = ergun_inertial_m(1.0, size.sauter_m, pores),
        .lbm = lattice_part(grids, fit, size.length_m),
        .inertial_permeability_m = fit.inertial_permeability_m,
        .inertial_permeability_interval_m = fit.inertial_interval_m,
        .beyond_largest_reynolds = fmt::format(
            "extrapolated: {}; the interval is {:.0f} % wider on both sides (turbulent coefficients differ: Fand et al. 1987)",
            config.mean_in_time ? "no flow was computed there" : "there is no steady flow to compute", 100.0 * turbulent_change),
        .expected_memory_bytes = expected.memory_bytes};
    result.lbm.method += by_device(config.device);
    result.interval_meaning = result.lbm.interval_meaning;
    if (config.openfoam) {
        const std::vector<double> drops = pressure_drops(config.reynolds, curve_of(grids.back()), fit, space.computed().length(),
                                                         size.length_m, water_viscosity_m2_per_s);
        result.openfoam = foam_part(space, geometry, config, drops, size.length_m, folder / "foam");
    }
    result.peak_memory_bytes = peak_memory_bytes();
    return {result, files_of(result)};
}

Expectation expect_inertia(const PoreSpace& space, const ForchheimerConfig& config) {
    PoreSpace pores = without_reservoir(space);
    pores.reservoir_m = water_depth(space);
    const VoxelPlan plan = pores.plan_at(finest_voxel(space, config));
    const double cells = static_cast<double>(plan.grid.size()), porosity = space.porosity(4000).value,
                 pore_volume = space.container.vessel().mean_area(pores.computed().interval()) *
                               (porosity * pores.computed().length() + 2.0 * pores.reservoir_m),
                 links = expected_links_per_node(porosity, space.grain_size_m / plan.voxel_size_m);
    const double fluid = pore_volume / std::pow(plan.voxel_size_m, 3), flows = static_cast<double>(config.reynolds.size());
    const RunSize size{.cells = cells, .nodes = fluid, .links_per_node = links};
    Expectation expected{.text = fmt::format("{} flows on {} grids, the finest {} x {} x {} voxels of {:.4g} m", config.reynolds.size(),
                                             config.grids, plan.grid.cells[0], plan.grid.cells[1], plan.grid.cells[2], plan.voxel_size_m),
                         // Voxels, moments (means in time: and a copy) and wall links are kept.
                         .memory_bytes = lbm_memory_bytes(size) + cells + ((config.mean_in_time ? 64.0 : 32.0) + 8.0 * links) * fluid};
    // Means in time: at least 40 turnovers; a node is passed in about 40 steps.
    const double steps = config.mean_in_time ? 40.0 * 40.0 * grain_size(space).length_m / plan.voxel_size_m : 1000.0;
    expected.wall_time_s = flows * steps * fluid / lattice_updates_per_second;
    expected.text += use_of_device(config.device, size, expected.wall_time_s);
    if (config.openfoam) {
        // Measured: 300 iterations per flow, 5 us per cell and iteration.
        const double foam_cells = expected_foam_cells(pores, finest_cell(space, config), config.surface_level, space.porosity(4000).value);
        expected.memory_bytes = std::max(expected.memory_bytes, foam_memory_bytes(foam_cells));
        expected.disk_bytes = foam_disk_bytes(foam_cells) * flows;
        expected.wall_time_s += flows * 300.0 * 5e-6 * foam_cells / static_cast<double>(config.processes);
        expected.text += fmt::format(", and by OpenFOAM on about {:.2g} cells", foam_cells);
    }
    return expected;
}

}  // namespace porepack::analysis
