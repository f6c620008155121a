#include "analysis/foam.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "analysis/uses.hpp"
#include "converters/surface.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/machine.hpp"
#include "openfoam/foam.hpp"
#include "openfoam/foam_cost.hpp"

namespace porepack::analysis {
namespace {

void require_surface(const PoreSpace& space) {
    if (space.closing_radius_m > 0.0)
        throw UserError("OpenFOAM's mesh is made from the grains, without menisci",
                        {.where = space.source, .fix = "remove closing_radius_m"});
    if (!space.packing() && !space.surface())
        throw UserError("OpenFOAM needs a surface, and the input is an image",
                        {.where = space.source, .fix = "porepack lbm, or porepack image segment, which writes solid.stl"});
}

double cell_size_m(const PoreSpace& space, const FoamConfig& config) {
    if (config.cell_size_m > 0.0) return config.cell_size_m;
    if (std::isfinite(space.known_grain_diameter_m())) return space.known_grain_diameter_m() / 4.0;
    throw UserError("the cell size is missing", {.fix = "--cell-size (metres), or cell_size_m in [openfoam]"});
}

const char* interval_meaning(const FoamConfig& config, const std::optional<FoamExtrapolation>& extrapolation) {
    if (config.meshes == 1 || !extrapolation) return "one mesh: no uncertainty";
    if (extrapolation->lost_pores)
        return "not extrapolated: the coarser mesh lacks pores; k of the finest mesh, the interval holds all meshes and the extrapolated k";
    if (config.meshes == 2) return "extrapolated from two meshes with order 1.5; the interval covers orders 1 to 2";
    if (!extrapolation->observed_order) return "three meshes without an order: the finest one, and three times the maximum change";
    return "extrapolated from three meshes with the observed order, the interval covers half an order more and less; or, if that order is "
           "outside 1.5 to 2.5, with order 2, covering 1 to 3";
}

}  // namespace

Expectation expect_foam(const PoreSpace& space, const FoamConfig& config, double cell_size_m, double pores) {
    const auto block = background_cells(space.container, space.computed(), cell_size_m);
    Expectation expected{.text = fmt::format("background {} x {} x {}", block[0], block[1], block[2])};
    for (long mesh = 0; mesh < config.meshes; ++mesh) {
        const double cells =
            expected_foam_cells(space, cell_size_m * std::pow(config.mesh_ratio, static_cast<double>(mesh)), config.surface_level, pores);
        if (mesh == 0) expected.text += fmt::format(", about {:.2g} cells in the finest mesh", cells);
        if (mesh < 2) expected.memory_bytes += foam_memory_bytes(cells);  // the coarser meshes, one after the other, beside the finest
        expected.disk_bytes += foam_disk_bytes(cells);
        // Measured: 0.4 ms per cell for meshing and solving.
        const double seconds = 0.4e-3 * cells / std::min(2.0, static_cast<double>(mesh == 0 ? config.processes : 1));
        if (mesh == 0 || thread_count() == 1) expected.wall_time_s += seconds;
    }
    return expected;
}

Expectation expect_foam(const PoreSpace& space, const FoamConfig& config) {
    require_surface(space);
    return expect_foam(space, config, cell_size_m(space, config), space.porosity(4000).value);
}

results::Foam compute_foam_flow(const PoreSpace& space, const GeometryConfig& geometry, const FoamConfig& config, const Path& folder,
                                const TriangleSurface* made) {
    if (made == nullptr) require_surface(space);
    const double cell = cell_size_m(space, config);
    if (space.ends == Ends::paper)
        throw UserError("OpenFOAM has no ends of the paper",
                        {.allowed = "in_situ, planes", .fix = "disable OpenFOAM, or choose other ends"});
    const auto cells = background_cells(space.container, space.computed(), cell);
    const double count = static_cast<double>(cells[0]) * cells[1] * cells[2];
    if (cell > space.grain_size_m || count > 2e8)
        throw UserError(fmt::format("a background cell of {:g} m does not fit the scene: {} x {} x {} cells, grains {:g} m thick", cell,
                                    cells[0], cells[1], cells[2], space.grain_size_m),
                        {.allowed = "cells smaller than that, at most 2e8 of them", .fix = "the cell size is in metres"});
    const double exact = space.porosity().value;
    const Expectation expected = expect_foam(space, config, cell, exact);
    require_memory(expected.memory_bytes, "the OpenFOAM mesh", "use larger cells or a shorter section");

    const double coarsest = cell * std::pow(config.mesh_ratio, static_cast<double>(config.meshes - 1));
    const FoamScene scene = foam_scene(space, surface_options(geometry), coarsest, made);
    const FoamResult result = foam_permeability(scene, config, cell, data_file("openfoam_cases"), folder);
    const auto& extrapolation = result.extrapolation;
    const auto converged = [](const FoamMeshResult& mesh) { return mesh.converged; };
    return {
        .permeability = {result.permeability_m2, extrapolation ? std::optional(extrapolation->interval) : std::nullopt},
        .conductance_m3 = result.permeability_m2 * space.container.vessel().mean_area(space.section.interval()) / space.section.length(),
        .method = "OpenFOAM simpleFoam, creeping flow, snappyHexMesh",
        .repeat_by_hand = "cd mesh_fine && ./Allclean && ./Allrun",
        .interval_meaning = interval_meaning(config, extrapolation),
        .observed_order = extrapolation ? extrapolation->observed_order : std::nullopt,
        .grid_convergence_index = extrapolation ? extrapolation->grid_convergence_index : std::nullopt,
        .section_m = space.section.interval(),
        .ends = space.container.periodic()[2] ? "periodic" : std::string(name_of(space.ends)),
        .buffers_m = space.buffers_m,
        .converged = std::all_of(result.meshes.begin(), result.meshes.end(), converged),
        .cells = result.fine().cells,
        .iterations = result.fine().iterations,
        .fine = result.fine(),
        .meshes = result.meshes,
        .expected_memory_bytes = expected.memory_bytes};
}

}  // namespace porepack::analysis
