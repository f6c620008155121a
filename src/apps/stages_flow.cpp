// The stages that compute permeabilities.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/machine.hpp"
#include "lbm/permeability.hpp"
#include "openfoam/foam.hpp"

namespace porepack {
namespace {

void write_history(const Path& file, const LbmGridResult& grid) {
    std::string text = "step,permeability_m2,iteration_error,flow_imbalance\n";
    const double h2 = grid.voxel_size_m * grid.voxel_size_m;
    for (const auto& point : grid.run.history)
        text += fmt::format("{},{:.12g},{:.6g},{:.6g}\n", point.step, point.permeability_volume_lu * h2, point.iteration_error,
                            point.flow_imbalance);
    write_text(file, text);
}

Json lbm_json(const LbmResult& result, const Section& section, const LbmConfig& config, bool exact_walls, const Path& folder) {
    const LbmGridResult& fine = result.fine();
    const Scheme scheme = scheme_of(config, exact_walls, {});
    Json json;
    add_permeability(json, result.permeability_m2, result.interval_m2());
    json["half_width_parts_m2"] = nullptr;
    if (result.half_width)
        json["half_width_parts_m2"] = {{"grid", result.half_width->grid_m2},
                                       {"iteration", result.half_width->iteration_m2},
                                       {"ends", result.half_width->ends_m2},
                                       {"precision", result.half_width->precision_m2}};
    json["interval_meaning"] = !result.half_width ? "too few grids: no uncertainty"
                               : scheme.walls == Walls::interpolated
                                   ? "three grids: covers the answer in 95 % of cases or more that are known"
                                   : "two grids, first order, at least the 4 % by which bounce-back scatters";
    if (config.tolerance > 0.0) {
        json["tolerance"] = config.tolerance;
        json["tolerance_reached"] = result.stopped_by.empty();
        json["stopped_by"] = result.stopped_by.empty() ? Json(nullptr) : Json(result.stopped_by);
    }
    json["permeability_by_volume_average_m2"] = fine.permeability_volume_m2;
    json["method"] =
        fmt::format("D3Q19 {}, linear equilibrium, {}, {} precision", config.collision == "bgk" ? "BGK" : "two relaxation times",
                    scheme.walls == Walls::interpolated ? "interpolated walls" : "half-way bounce-back", config.precision);
    json["direction"] = config.direction;
    json["driven_by"] = config.ends == "paper" ? "the inlet's flow rate" : fine.by_pressure ? "pressure planes" : "body force";
    json["section_m"] = list(section);
    json["converged"] = fine.run.converged;
    json["iteration_error"] = fine.run.iteration_error;
    json["flow_imbalance"] = fine.run.flow_imbalance;
    json["hydraulic_tortuosity"] = fine.run.hydraulic_tortuosity;
    json["magic_number"] = scheme.magic;
    json["steps"] = fine.run.steps;
    json["updates_per_second"] = fine.run.updates_per_second;
    json["fine"] = to_json(fine);
    json["grids"] = Json::array();
    for (const LbmGridResult& grid : result.grids) json["grids"].push_back(to_json(grid));
    json["subsections"] = Json::array();
    for (const auto& part : result.subsections)
        json["subsections"].push_back({{"z0_m", part.z0_m}, {"z1_m", part.z1_m}, {"permeability_m2", part.permeability_m2}});
    json["peak_memory_bytes"] = peak_memory_bytes();
    write_history(folder / "history.csv", fine);
    if (config.fields != "none") write_flow_image(folder / "flow.vti", result.flow);
    return json;
}

}  // namespace

Json lbm_stage(const Scene& scene, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder, const Path& checkpoint) {
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
    const LbmScene pore_space{.voxels = [&](double size) { return voxelise(scene.solid(), scene.container, scene.section, voxels(size)); },
                              .solid = &scene.solid(),
                              .container = scene.container,
                              .section = scene.section,
                              .grain_size_m = scene.grains ? scene.grain_size_m : std::numeric_limits<double>::infinity(),
                              .checkpoint = checkpoint};
    Json json;
    if (config.tensor) {
        const TensorResult tensor = lbm_tensor(pore_space, plan.voxel_size_m, config);
        json = lbm_json(tensor.runs[std::string("xyz").find(config.direction)], scene.section, config, true, folder);
        json["permeability_tensor_m2"] = tensor.permeability_m2;
    } else {
        json = lbm_json(lbm_permeability(pore_space, plan.voxel_size_m, config, true), scene.section, config, true, folder);
    }
    json["expected_memory_bytes"] = expected.memory_bytes;
    return json;
}

Json lbm_image_stage(const Path& pore_vti, const std::optional<Container>& container, const std::vector<double>& section_m,
                     const LbmConfig& config, const Path& folder) {
    const auto [image, vessel, section] = load_image(pore_vti, container, section_m);
    const auto& grid = image.grid;
    for (const double spacing : grid.spacing_m)
        if (std::abs(spacing / grid.spacing_m[0] - 1.0) > 1e-6)
            throw UserError(
                fmt::format("the voxels are not cubic: {:g} x {:g} x {:g} m", grid.spacing_m[0], grid.spacing_m[1], grid.spacing_m[2]),
                {.where = pore_vti.string(), .mend = "resample the image"});
    LbmConfig one = config;
    one.grids = 1;  // an image has one resolution
    if (one.tolerance > 0.0)
        throw UserError("an image has one resolution: no finer grid can reach a tolerance",
                        {.where = pore_vti.string(), .mend = "leave the tolerance out, or give packing.json or the STL file"});
    const LbmScene pores{.voxels = [&image = image](double) { return image; }, .solid = nullptr, .container = vessel, .section = section};
    return lbm_json(lbm_permeability(pores, grid.spacing_m[0], one, true), section, one, false, folder);
}

FoamScene foam_scene(const Scene& scene, const GeometryConfig& geometry, double coarsest_cell_m) {
    FoamScene foam{.surface = {}, .container = scene.container, .section = scene.section};
    if (scene.surface) {
        foam.surface = *scene.surface;
    } else {
        Packing near = *scene.packing;  // only the grains that reach into the section
        if (!scene.container.any_periodic())
            std::erase_if(near.bodies, [&](const Body& body) {
                return body.position_m.z() < scene.section.z0 - scene.grain_span_m ||
                       body.position_m.z() > scene.section.z1 + scene.grain_span_m;
            });
        foam.surface = make_surface(near, {.deviation_m = geometry.surface_deviation_m, .contact_gap_m = geometry.contact_gap_m}).surface;
    }
    foam.pore_volume_m3 =
        porosity(scene.solid(), scene.container, scene.section).value * scene.container.inner_area_m2() * scene.section.length();
    foam.grain_size_m = scene.grain_size_m;
    foam.narrow_pores = [&scene](double size) {
        if (scene.container.any_periodic()) size = scene.section.length() / std::ceil(scene.section.length() / size);
        const VoxelPlan plan = plan_voxels(scene.container, scene.section, size, 0.0, scene.grain_size_m);
        return narrow_fraction(voxelise(scene.solid(), scene.container, scene.section, plan), 2);
    };
    const double probe = scene.container.any_periodic()
                             ? scene.section.length() / std::ceil(scene.section.length() / (0.5 * coarsest_cell_m))
                             : 0.5 * coarsest_cell_m;
    foam.pore_point = find_pore_point(voxelise(scene.solid(), scene.container, scene.section,
                                               plan_voxels(scene.container, scene.section, probe, 0.0, scene.grain_size_m)),
                                      scene.container);
    return foam;
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

    const FoamScene foam = foam_scene(scene, geometry, cell * std::pow(config.mesh_ratio, static_cast<double>(config.meshes - 1)));
    const FoamResult result = foam_permeability(foam, config, cell, home_folder() / "openfoam_cases", folder);

    const auto mesh_json = [](const FoamMeshResult& mesh) -> Json {
        return {{"cell_size_m", mesh.cell_size_m},
                {"cells", mesh.cells},
                {"max_non_orthogonality_deg", mesh.max_non_orthogonality},
                {"skew_faces", mesh.skew_faces},
                {"mesh_volume_ratio", mesh.mesh_volume_ratio},
                {"narrow_pores", mesh.narrow_pores},
                {"iterations", mesh.iterations},
                {"converged", mesh.converged},
                {"flow_imbalance", mesh.flow_imbalance},
                {"flow_drift", mesh.flow_drift},
                {"permeability_m2", mesh.permeability_m2},
                {"processes", mesh.processes},
                {"wall_time_s", mesh.wall_time_s},
                {"peak_memory_bytes", mesh.peak_memory_bytes}};
    };
    Json json;
    add_permeability(json, result.permeability_m2, result.extrapolation ? std::optional(result.extrapolation->interval) : std::nullopt);
    json["method"] = "OpenFOAM simpleFoam, creeping flow, snappyHexMesh";
    json["repeat_by_hand"] = "cd mesh_fine && ./Allclean && ./Allrun";
    const auto optional = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
    const auto& extrapolation = result.extrapolation;
    json["interval_meaning"] = config.meshes == 1   ? "one mesh: no uncertainty"
                               : config.meshes == 2 ? "extrapolated from two meshes with order 1.5; the interval spans orders 1 to 2"
                               : extrapolation->observed_order
                                   ? "extrapolated from three meshes with the observed order, the interval spans half an order more and "
                                     "less; or, where that order is "
                                     "outside 1.5 to 2.5, with order 2, spanning 1 to 3"
                                   : "three meshes without an order: the finest one, and three times the largest change";
    json["observed_order"] = extrapolation ? optional(extrapolation->observed_order) : Json(nullptr);
    json["grid_convergence_index"] = extrapolation ? optional(extrapolation->grid_convergence_index) : Json(nullptr);
    json["section_m"] = list(scene.section);
    json["converged"] =
        std::all_of(result.meshes.begin(), result.meshes.end(), [](const FoamMeshResult& mesh) { return mesh.converged; });
    json["cells"] = result.fine().cells;
    json["iterations"] = result.fine().iterations;
    json["fine"] = mesh_json(result.fine());
    json["meshes"] = Json::array();
    for (const FoamMeshResult& mesh : result.meshes) json["meshes"].push_back(mesh_json(mesh));
    json["expected_memory_bytes"] = expected.memory_bytes;
    return json;
}

Expectation expect_lbm(const Container& container, const Section& section, double voxel_size_m, double grain_size_m, double pores,
                       const GeometryConfig& geometry, const LbmConfig& config) {
    const VoxelPlan plan = plan_voxels(container, section, voxel_size_m, geometry.reservoir_m, grain_size_m);
    const double cells = static_cast<double>(plan.grid.size());
    const double fluid = pores * container.inner_area_m2() * section.length() / std::pow(plan.voxel_size_m, 3);
    const double flow_vti = config.fields == "none" ? 0.0 : 4e7 + 20.0 * fluid + 34.0 * cells;
    Expectation expected{.memory_bytes = std::max(flow_vti, lbm_memory_bytes(cells, fluid, config.precision == "single" ? 4.0 : 8.0))};
    // Steps grow with the square of the pores' width in voxels, and with the length; rate of about 8 million a second and thread.
    const double steps = std::max(400.0, 4.0 * std::pow(grain_size_m / plan.voxel_size_m, 2.0));
    const double coarse = config.grids > 1 ? 1.0 / (1.0 - std::pow(config.grid_ratio, -5.0)) : 1.0;
    expected.wall_time_s = coarse * steps * fluid / (8e6 * thread_count());
    expected.text = fmt::format("{} x {} x {} voxels of {:.4g} m, about {:.2g} fluid nodes", plan.grid.cells[0], plan.grid.cells[1],
                                plan.grid.cells[2], plan.voxel_size_m, fluid);
    if (config.tolerance > 0.0)
        expected.text += fmt::format(
            "; with a tolerance the grids go from 6 voxels a diameter to what {:g} needs, and these numbers are those of this one",
            config.tolerance);
    return expected;
}

Expectation expect_foam(const Container& container, const Section& section, double cell_size_m, double pores, const FoamConfig& config) {
    const auto block = background_cells(container, section, cell_size_m);
    const double background = pores * container.inner_area_m2() * section.length() / std::pow(cell_size_m, 3);
    const double cells = background * std::pow(2.5, config.surface_level);
    // Measured: 0.45 ms a cell for meshing and solving, 1.6 kB a cell.
    const double coarse = config.meshes > 1 ? 1.0 + std::pow(config.mesh_ratio, -3.0) : 1.0;
    return {.text = fmt::format("background {} x {} x {}, about {:.2g} cells in the finest mesh", block[0], block[1], block[2], cells),
            .memory_bytes = 1e8 + 1600.0 * cells,
            .wall_time_s = coarse * 0.45e-3 * cells};
}

}  // namespace porepack
