#include "apps/stages.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "lbm/permeability.hpp"
#include "openfoam/foam.hpp"
#include "packing/liggghts.hpp"
#include "permeability/permeability.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack {
namespace {

Json list(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

Json list(const Section& section) {
    return {section.z0, section.z1};
}

Json list(const std::optional<Interval>& interval) {
    if (!interval) return nullptr;
    return {interval->low, interval->high};
}

// The section as an image's field data tells it.
Section section_of_note(const std::string& note, const Path& file) {
    Section section;
    if (std::sscanf(note.c_str(), "%lf,%lf", &section.z0, &section.z1) != 2)
        throw UserError("the image's field data `section` is not \"z0,z1\": " + note,
                        {.where = file.string(), .mend = "--section z0,z1 (metres)"});
    return section;
}

void add_porosity(Json& json, const Scene& scene) {
    const Porosity section = porosity(scene.solid(), scene.container, scene.section);
    json["section_m"] = list(scene.section);
    json["porosity"] = section.value;
    json["porosity_uncertainty"] = section.uncertainty;
    if (scene.container.periodic[2]) return;
    const Porosity bed = porosity(scene.solid(), scene.container, {0.0, scene.bed_top_m});
    json["bed_height_m"] = scene.bed_top_m;
    json["porosity_bed"] = bed.value;
    json["porosity_bed_uncertainty"] = bed.uncertainty;
}

// k in the units that people use.
void add_permeability(Json& json, double permeability_m2, const std::optional<Interval>& interval) {
    json["permeability_m2"] = permeability_m2;
    json["permeability_interval_m2"] = list(interval);
    json["permeability_darcy"] = permeability_m2 / darcy_m2;
    json["conductivity_m_per_s"] = conductivity_m_per_s(permeability_m2);
}

}  // namespace

Path home_folder() {
    const char* home = std::getenv("POREPACK_HOME");
    const Path folder = home != nullptr ? Path(home) : Path(POREPACK_SOURCE_FOLDER);
    if (!std::filesystem::exists(folder / "liggghts_templates"))
        throw UserError("the folder liggghts_templates/ is not in " + folder.string(),
                        {.mend = "set POREPACK_HOME to the project's folder"});
    return folder;
}

Json shape_stage(const ShapeConfig& config, double density) {
    const Shape shape = make_shape(config);
    const ShapeMeasures m = measure(shape);
    Json json = {{"kind", config.kind}, {"cavity", shape.cavity == Cavity::filled ? "filled" : "open"}};
    if (config.kind != "capsules") {
        json["diameter_m"] = 2.0 * shape.capsules.front().radius;
        json["length_m"] = (shape.capsules.front().b - shape.capsules.front().a).norm();
    }
    json["capsules"] = shape.capsules.size();
    json["volume_m3"] = m.volume_m3;
    json["surface_area_m2"] = m.surface_area_m2;
    json["sphericity"] = m.sphericity;
    json["convexity"] = m.volume_m3 / hull_volume(shape.capsules);
    json["equal_volume_diameter_m"] = std::cbrt(6.0 * m.volume_m3 / std::numbers::pi);
    json["cavity_volume_m3"] = m.cavity_volume_m3;
    json["centre_of_mass_m"] = list(m.centre_of_mass_m);
    json["density_kg_per_m3"] = density;
    json["mass_kg"] = density * m.volume_m3;
    json["inertia_kg_m2"] = Json::array();
    for (int row = 0; row < 3; ++row) json["inertia_kg_m2"].push_back(list(Vec3(density * m.inertia_per_density_m5.row(row).transpose())));
    json["bounding_radius_m"] = m.bounding_radius_m;
    json["span_m"] = m.span_m;
    json["relative_error"] = m.relative_error;
    return json;
}

Json surface_shape_stage(const Path& stl, double unit_m) {
    const SurfaceCheck check = check_surface(read_stl(stl, unit_m));
    require_sound(check, stl.string());
    return {{"kind", "stl"},
            {"shells", check.shells},
            {"volume_m3", check.volume_m3},
            {"surface_area_m2", check.area_m2},
            {"low_m", list(check.low)},
            {"high_m", list(check.high)}};
}

Json pack_stage(const Case& the_case, const Path& folder) {
    const auto& config = the_case.settings.packing;
    const Container container = make_container(the_case.settings.container);
    Json json = {{"engine", config.engine}, {"seed", config.seed}};
    Packing packing;
    if (config.engine == "none") {
        if (config.file.empty())
            throw UserError("engine = \"none\" needs a packing", {.where = "[packing]", .mend = "file = \"packing.json\""});
        packing = read_packing(the_case.resolve(config.file));
        if (to_json(packing.container) != to_json(container))
            throw UserError("the container of the packing is not the one of the case",
                            {.where = config.file,
                             .allowed = to_json(container).dump(),
                             .mend = "[container] must say " + to_json(packing.container).dump()});
    } else {
        const Shape shape = make_shape(the_case.settings.shape);
        const PourResult pour = pour_with_liggghts(shape, container, config, home_folder() / "liggghts_templates", folder / "run");
        packing = pour.packing;
        const double d = smallest_diameter(shape);
        json["batches"] = pour.batches;
        json["steps"] = pour.steps;
        json["kinetic_energy_per_grain_J"] = pour.kinetic_energy_per_grain_J;
        json["rest_limit_J"] = pour.rest_limit_J;
        json["at_rest"] = true;
        json["pose_error_relative_to_diameter"] = pour.pose_error_m / d;
        json["clump_spheres"] = sphere_clump(shape, config.surface_tolerance * d).size();
        json["repeat_by_hand"] = "cd run && " + pour.command;
        json["engine_wall_time_s"] = pour.wall_time_s;
    }
    const Overlaps overlaps = find_overlaps(packing);
    double d = 1e300;
    for (const auto& shape : packing.shapes) d = std::min(d, smallest_diameter(shape));
    json["grains"] = packing.bodies.size();
    json["largest_overlap_relative_to_diameter"] = overlaps.largest_between_grains_m / d;
    json["mean_overlap_relative_to_diameter"] = overlaps.mean_between_grains_m / d;
    json["largest_wall_overlap_relative_to_diameter"] = overlaps.largest_with_wall_m / d;
    json["contacts"] = overlaps.contacts;
    write_packing(folder / "packing.json", packing);
    add_porosity(json, load_scene(folder / "packing.json", std::nullopt, the_case.settings.geometry, 1.0));
    return json;
}

Json stl_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder) {
    Json json;
    const Path file = folder / "solid.stl";
    if (scene.packing) {
        const SurfaceResult result =
            make_surface(*scene.packing, {.deviation_m = geometry.surface_deviation_m, .contact_gap_m = geometry.contact_gap_m});
        write_stl(file, result.surface);
        const Porosity exact = porosity(*scene.grains, scene.container, {0.0, scene.container.height()});
        const double solid = (1.0 - exact.value) * scene.container.inner_area_m2() * scene.container.height();
        json["largest_deviation_m"] = result.deviation_m;
        json["contact_gap_m"] = result.contact_gap_m;
        json["joined_grains"] = result.joined_grains;
        json["thinned_grains"] = result.shrunk_grains;
        if (!scene.container.any_periodic()) json["exact_volume_m3"] = solid;
    } else {
        write_stl(file, *scene.surface);
    }
    // What is claimed is checked on the file as it was written, in single precision.
    const SurfaceCheck check = check_surface(read_stl(file));
    if (!check.fault.empty())
        throw NumericalError("the surface written is not sound: " + check.fault,
                             {.where = file.string(), .mend = "change surface_deviation_m or contact_gap_m"});
    json["triangles"] = (std::filesystem::file_size(file) - 84) / 50;
    json["shells"] = check.shells;
    json["closed"] = check.closed;
    json["outward"] = check.outward;
    json["self_intersecting"] = check.self_intersecting;
    json["volume_m3"] = check.volume_m3;
    json["area_m2"] = check.area_m2;
    if (json.contains("exact_volume_m3")) json["volume_error"] = check.volume_m3 / json["exact_volume_m3"].get<double>() - 1.0;
    if (!scene.packing) add_porosity(json, scene);
    return json;
}

Json voxelise_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder) {
    const VoxelPlan plan =
        plan_voxels(scene.container, scene.section, scene.voxel_size(geometry), geometry.reservoir_m, scene.grain_size_m);
    const PhaseImage image = voxelise(scene.solid(), scene.container, scene.section, plan);
    write_phase_image(folder / "pore.vti", image);
    std::array<double, 3> count = {0, 0, 0};
    for (const auto phase : image.phase) count[phase] += 1.0;
    const Porosity exact = porosity(scene.solid(), scene.container, scene.section);
    return {{"voxel_size_m", plan.voxel_size_m},
            {"cells", plan.grid.cells},
            {"section_m", list(scene.section)},
            {"reservoir_cells", plan.reservoir_cells},
            {"porosity_of_voxels", count[pore] / (count[pore] + count[grain])},
            {"porosity", exact.value},
            {"porosity_uncertainty", exact.uncertainty},
            {"expected_memory_bytes", plan.memory_bytes}};
}

Json slices_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder) {
    const int count = write_slices(folder, scene.solid(), scene.container, scene.section, geometry.slice_spacing_m, geometry.slice_pixel_m);
    return {{"slices", count},
            {"spacing_m", geometry.slice_spacing_m},
            {"pixel_m", geometry.slice_pixel_m},
            {"section_m", list(scene.section)}};
}

namespace {

void write_history(const Path& file, const LbmGridResult& grid) {
    std::string text = "step,permeability_m2,iteration_error,flow_imbalance\n";
    const double h2 = grid.voxel_size_m * grid.voxel_size_m;
    for (const auto& point : grid.run.history)
        text +=
            fmt::format("{},{:.12g},{:.6g},{:.6g}\n", point.step, point.permeability_lu * h2, point.iteration_error, point.flow_imbalance);
    write_text(file, text);
}

Json grid_json(const LbmGridResult& grid) {
    return {{"voxel_size_m", grid.voxel_size_m},
            {"cells", grid.cells},
            {"fluid_nodes", grid.nodes},
            {"isolated_cells", grid.isolated_cells},
            {"permeability_m2", grid.permeability_m2},
            {"steps", grid.run.steps},
            {"seconds", grid.run.seconds},
            {"updates_per_second", grid.run.updates_per_second},
            {"bytes_per_node", grid.bytes_per_node}};
}

Json lbm_json(const LbmResult& result, const Section& section, const LbmConfig& config, const Path& folder) {
    Json json;
    add_permeability(json, result.fine.permeability_m2, result.interval_m2);
    json["permeability_by_volume_average_m2"] = result.fine.permeability_volume_m2;
    json["method"] = "D3Q19 two relaxation times, linear equilibrium, half-way bounce-back";
    json["interval_meaning"] =
        result.interval_m2
            ? "first-order Richardson estimate from two grids; bounce-back on voxels converges irregularly, so it is indicative"
            : "one grid: no uncertainty";
    json["direction"] = config.direction;
    json["driven_by"] = result.fine.by_pressure ? "pressure planes" : "body force";
    json["section_m"] = list(section);
    json["converged"] = result.fine.run.converged;
    json["iteration_error"] = result.fine.run.iteration_error;
    json["flow_imbalance"] = result.fine.run.flow_imbalance;
    json["hydraulic_tortuosity"] = result.fine.run.hydraulic_tortuosity;
    json["steps"] = result.fine.run.steps;
    json["updates_per_second"] = result.fine.run.updates_per_second;
    json["relaxation_time"] = config.relaxation_time;
    json["magic_number"] = config.magic_number;
    json["permeability_lu"] = result.fine.run.permeability_lu;
    json["superficial_velocity_lu"] = result.fine.run.superficial_velocity_lu;
    json["fine"] = grid_json(result.fine);
    json["coarse"] = result.coarse ? grid_json(*result.coarse) : Json(nullptr);
    json["peak_memory_bytes"] = peak_memory_bytes();
    write_history(folder / "history.csv", result.fine);
    write_flow_image(folder / "flow.vti", result.flow);
    return json;
}

}  // namespace

Json lbm_stage(const Scene& scene, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder) {
    const auto voxels = [&](double size) {
        return plan_voxels(scene.container, scene.section, size, geometry.reservoir_m, scene.grain_size_m);
    };
    const VoxelPlan plan = voxels(scene.voxel_size(geometry));
    const Porosity pores = porosity(scene.solid(), scene.container, scene.section, 4000);
    const Expectation expected =
        expect_lbm(scene.container, scene.section, plan.voxel_size_m, scene.grain_size_m, pores.value, geometry, config);
    require_memory(expected.memory_bytes,
                   fmt::format("the flow on {} x {} x {} voxels", plan.grid.cells[0], plan.grid.cells[1], plan.grid.cells[2]),
                   "take a larger voxel size or a shorter section");
    const LbmResult result =
        lbm_permeability([&](double size) { return voxelise(scene.solid(), scene.container, scene.section, voxels(size)); },
                         plan.voxel_size_m, scene.container, scene.section, config, true);
    Json json = lbm_json(result, scene.section, config, folder);
    json["expected_memory_bytes"] = expected.memory_bytes;
    return json;
}

Json lbm_image_stage(const Path& pore_vti, const std::optional<Container>& container, const std::vector<double>& section_m,
                     const LbmConfig& config, const Path& folder) {
    const PhaseImage image = read_phase_image(pore_vti);
    const auto& grid = image.grid;
    for (const double spacing : grid.spacing_m)
        if (std::abs(spacing / grid.spacing_m[0] - 1.0) > 1e-6)
            throw UserError(
                fmt::format("the voxels are not cubic: {:g} x {:g} x {:g} m", grid.spacing_m[0], grid.spacing_m[1], grid.spacing_m[2]),
                {.where = pore_vti.string(), .mend = "resample the image"});
    Container vessel;
    if (container)
        vessel = *container;
    else if (image.notes.contains("container"))
        vessel = container_from_json(Json::parse(image.notes.at("container")), pore_vti.string());
    else
        throw UserError("the image does not say what its container is",
                        {.where = pore_vti.string(), .mend = "--container cylinder:D,H or box:X,Y,Z[:periodic] (metres)"});
    Section section{grid.origin_m[2], grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2]};
    if (section_m.size() == 2)
        section = {section_m[0], section_m[1]};
    else if (image.notes.contains("section"))
        section = section_of_note(image.notes.at("section"), pore_vti);
    LbmConfig one = config;
    one.grids = 1;  // an image has one resolution
    return lbm_json(lbm_permeability([&](double) { return image; }, grid.spacing_m[0], vessel, section, one, true), section, one, folder);
}

Json foam_stage(const Scene& scene, const GeometryConfig& geometry, const FoamConfig& config, const Path& folder) {
    const double cell = config.cell_size_m > 0.0 ? config.cell_size_m
                        : scene.grains
                            ? scene.grain_size_m / 4.0
                            : throw UserError("the cell size is missing", {.mend = "--cell-size (metres), or cell_size_m in [openfoam]"});
    const auto cells = background_cells(scene.container, scene.section, cell);
    const double count = static_cast<double>(cells[0]) * cells[1] * cells[2];
    if (cell > scene.grain_size_m || count > 2e8)
        throw UserError(fmt::format("a background cell of {:g} m does not fit the scene: {} x {} x {} cells, capsule diameter {:g} m", cell,
                                    cells[0], cells[1], cells[2], scene.grain_size_m),
                        {.allowed = "cells smaller than the capsules, at most 2e8 of them", .mend = "the cell size is in metres"});
    const double exact = porosity(scene.solid(), scene.container, scene.section).value;
    const Expectation expected = expect_foam(scene.container, scene.section, cell, exact, config);
    require_memory(expected.memory_bytes, "the OpenFOAM mesh", "take larger cells or a shorter section");

    FoamScene foam{.surface = {}, .container = scene.container, .section = scene.section};
    foam.surface =
        scene.surface
            ? *scene.surface
            : make_surface(*scene.packing, {.deviation_m = geometry.surface_deviation_m, .contact_gap_m = geometry.contact_gap_m}).surface;
    foam.pore_volume_m3 = exact * scene.container.inner_area_m2() * scene.section.length();
    foam.grain_size_m = scene.grain_size_m;
    const double coarsest = cell * (config.meshes == 2 ? config.mesh_ratio : 1.0);
    const double probe =
        scene.container.any_periodic() ? scene.section.length() / std::ceil(scene.section.length() / (0.5 * coarsest)) : 0.5 * coarsest;
    foam.pore_point = find_pore_point(voxelise(scene.solid(), scene.container, scene.section,
                                               plan_voxels(scene.container, scene.section, probe, 0.0, scene.grain_size_m)),
                                      scene.container);
    const FoamResult result = foam_permeability(foam, config, cell, home_folder() / "openfoam_cases", folder);

    const auto mesh_json = [](const FoamMeshResult& mesh) -> Json {
        return {{"cell_size_m", mesh.cell_size_m},
                {"cells", mesh.cells},
                {"max_non_orthogonality_deg", mesh.max_non_orthogonality},
                {"mesh_volume_ratio", mesh.mesh_volume_ratio},
                {"iterations", mesh.iterations},
                {"flow_imbalance", mesh.flow_imbalance},
                {"flow_drift", mesh.flow_drift},
                {"permeability_m2", mesh.permeability_m2},
                {"wall_time_s", mesh.wall_time_s},
                {"peak_memory_bytes", mesh.peak_memory_bytes}};
    };
    Json json;
    add_permeability(json, result.permeability_m2, result.interval_m2);
    json["method"] = "OpenFOAM simpleFoam, creeping flow, snappyHexMesh";
    json["repeat_by_hand"] = "cd mesh_fine && ./Allclean && ./Allrun";
    json["interval_meaning"] =
        result.interval_m2 ? "extrapolated from two meshes with order 1.5; the interval spans orders 1 to 2" : "one mesh: no uncertainty";
    json["section_m"] = list(scene.section);
    json["converged"] = true;
    json["cells"] = result.fine.cells;
    json["iterations"] = result.fine.iterations;
    json["fine"] = mesh_json(result.fine);
    json["coarse"] = result.coarse ? mesh_json(*result.coarse) : Json(nullptr);
    json["expected_memory_bytes"] = expected.memory_bytes;
    return json;
}

namespace {

Json geometric_json(const GeometricPaperResult& result, const std::string& geometry) {
    return {{"kind", "geometric_paper"},
            {"geometry", geometry},
            {"tortuosity_geometric_paper", result.value},
            {"standard_error", result.standard_error},
            {"standard_deviation", result.standard_deviation},
            {"paths", result.paths},
            {"slices", result.slices},
            {"rejections_per_point", result.rejections_per_point}};
}

}  // namespace

Json geometric_paper_stage(const Scene& scene, const TortuosityConfig& config) {
    if (!scene.grains)
        throw UserError(
            "the exact dot method needs a packing",
            {.mend =
                 "make slices of the STL file and give their folder: porepack slices, then porepack tortuosity geometric_paper SLICES"});
    return geometric_json(geometric_paper_exact(*scene.grains, scene.container, scene.section, config), "exact");
}

Json geometric_paper_slices_stage(const Path& slices, const TortuosityConfig& config) {
    const SliceStack stack = read_slices(slices);
    Json json = geometric_json(geometric_paper_on_slices(stack, config), "pixels");
    json["pixel_m"] = stack.grid.spacing_m[0];
    return json;
}

Json hydraulic_stage(const Path& flow_vti, const std::vector<double>& section_m) {
    const FlowImage flow = read_flow_image(flow_vti);
    Section section{-1e300, 1e300};
    if (section_m.size() == 2)
        section = {section_m[0], section_m[1]};
    else if (flow.notes.contains("section"))
        section = section_of_note(flow.notes.at("section"), flow_vti);
    const std::string direction = flow.notes.contains("direction") ? flow.notes.at("direction") : "z";
    const int axis = direction == "x" ? 0 : direction == "y" ? 1 : 2;
    return {{"kind", "hydraulic"},
            {"direction", direction},
            {"tortuosity_hydraulic", hydraulic_tortuosity(flow, section, axis)},
            {"uncertainty", nullptr}};
}

Json falling_head_stage(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config, const Path* folder) {
    const FallingHead test(permeability_m2, inertial_permeability_m, config);
    Json json = {{"permeability_m2", permeability_m2},
                 {"inertial_permeability_m", std::isfinite(inertial_permeability_m) ? Json(inertial_permeability_m) : Json("infinite")},
                 {"sample_length_m", config.sample_length_m},
                 {"start_level_m", config.start_level_m},
                 {"levels_m", config.levels_m},
                 {"times_s", Json::array()}};
    for (const double level : config.levels_m) json["times_s"].push_back(test.time_at(level));
    json["start_speed_m_per_s"] = test.speed_at(config.start_level_m);
    json["equation"] = "Eq. 18, closed form, without the inertia of the water column";
    if (folder != nullptr) {
        std::string text = "time_s,level_m\n";
        const double end = test.time_at(0.0);
        for (int i = 0; i <= 200; ++i) text += fmt::format("{:.8g},{:.8g}\n", end * i / 200, std::max(0.0, test.level_at(end * i / 200)));
        write_text(*folder / "falling_head.csv", text);
    }
    return json;
}

Expectation expect_lbm(const Container& container, const Section& section, double voxel_size_m, double grain_size_m, double pores,
                       const GeometryConfig& geometry, const LbmConfig& config) {
    const VoxelPlan plan = plan_voxels(container, section, voxel_size_m, geometry.reservoir_m, grain_size_m);
    const double cells = static_cast<double>(plan.grid.size());
    const double fluid = pores * container.inner_area_m2() * section.length() / std::pow(plan.voxel_size_m, 3);
    Expectation expected{.memory_bytes = lbm_memory_bytes(cells, fluid) + 16.0 * cells};
    // Steps grow with the square of the pores' width in voxels, and with the length; rate of about 8 million a second and thread.
    const double steps = std::max(400.0, 4.0 * std::pow(grain_size_m / plan.voxel_size_m, 2.0)) * 1.2 / config.relaxation_time;
    const double coarse = config.grids == 2 ? 1.0 + std::pow(config.grid_ratio, -5.0) : 1.0;
    expected.wall_time_s = coarse * steps * fluid / (8e6 * thread_count());
    expected.text = fmt::format("{} x {} x {} voxels of {:.4g} m, about {:.2g} fluid nodes", plan.grid.cells[0], plan.grid.cells[1],
                                plan.grid.cells[2], plan.voxel_size_m, fluid);
    return expected;
}

Expectation expect_foam(const Container& container, const Section& section, double cell_size_m, double pores, const FoamConfig& config) {
    const auto block = background_cells(container, section, cell_size_m);
    const double background = pores * container.inner_area_m2() * section.length() / std::pow(cell_size_m, 3);
    const double cells = background * std::pow(2.5, config.surface_level);
    // Measured: 0.45 ms a cell for meshing and solving, 1.6 kB a cell.
    const double coarse = config.meshes == 2 ? 1.0 + std::pow(config.mesh_ratio, -3.0) : 1.0;
    return {.text = fmt::format("background {} x {} x {}, about {:.2g} cells in the finest mesh", block[0], block[1], block[2], cells),
            .memory_bytes = 1e8 + 1600.0 * cells,
            .wall_time_s = coarse * 0.45e-3 * cells};
}

}  // namespace porepack
