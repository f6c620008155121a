// The stages that compute tortuosities: four numbers with four names.
#include <fmt/format.h>

#include <cmath>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/machine.hpp"
#include "openfoam/foam_field.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack {
namespace {

void write_ways(const Path& file, const std::vector<std::vector<Vec3>>& ways) {
    std::vector<Line> lines;
    for (const auto& way : ways) {
        lines.emplace_back();
        for (const Vec3& point : way) lines.back().push_back({point.x(), point.y(), point.z()});
    }
    write_vtp(file, lines);
}

Json geometric_json(const GeometricPaperResult& result, const std::string& geometry, const Path& ways_vtp) {
    write_ways(ways_vtp, result.ways_m);
    return {{"kind", "geometric_paper"},
            {"geometry", geometry},
            {"tortuosity_geometric_paper", result.value},
            {"standard_error", result.standard_error},
            {"standard_deviation", result.standard_deviation},
            {"paths", result.paths},
            {"slices", result.slices},
            {"rejections_per_point", result.rejections_per_point},
            {"paths_file", ways_vtp.filename().string()}};
}

Json shortest_path_json(const ShortestPathResult& result, const std::string& direction, const std::string& geometry, double voxel_m,
                        const Path& way_vtp) {
    write_ways(way_vtp, result.ways_m);
    const double n = static_cast<double>(std::max(1L, result.starts));
    return {{"kind", "shortest_path"},
            {"direction", direction},
            {"geometry", geometry},
            {"voxel_size_m", voxel_m},
            {"tortuosity_shortest_path", result.value},
            {"meaning", "mean over starting points on the first end plane"},
            {"standard_error", result.standard_deviation / std::sqrt(n)},
            {"standard_deviation", result.standard_deviation},
            {"tortuosity_shortest_path_least", result.least},
            {"tortuosity_shortest_path_greatest", result.greatest},
            {"starts", result.starts},
            {"blocked_starts", result.blocked_starts},
            {"paths_file", way_vtp.filename().string()}};
}

Json diffusive_json(const DiffusiveResult& result, const std::string& direction) {
    return {{"kind", "diffusive"},
            {"direction", direction},
            {"tortuosity_diffusive", result.value},
            {"relative_diffusivity", result.relative_diffusivity},
            {"porosity", result.porosity},
            {"porosity_flowing", result.porosity_flowing},
            {"iterations", result.iterations},
            {"residual", result.residual},
            {"flux_imbalance", result.flux_imbalance},
            {"converged", result.converged}};
}

std::size_t axis_of(const std::string& direction) {
    return direction == "x" ? 0 : direction == "y" ? 1 : 2;
}

// The layers of the section alone.
PhaseImage cropped(const PhaseImage& image, const Section& section) {
    const double h = image.grid.spacing_m[2];
    const auto layer_at = [&](double z) { return static_cast<int>(std::lround((z - image.grid.origin_m[2]) / h)); };
    const int low = std::clamp(layer_at(section.z0), 0, image.grid.cells[2] - 1),
              high = std::clamp(layer_at(section.z1), low + 1, image.grid.cells[2]);
    PhaseImage part{.grid = image.grid, .phase = {}, .notes = image.notes};
    part.grid.cells[2] = high - low;
    part.grid.origin_m[2] += low * h;
    const std::size_t layer = image.grid.index(0, 0, 1);
    part.phase.assign(image.phase.begin() + static_cast<std::ptrdiff_t>(layer * static_cast<std::size_t>(low)),
                      image.phase.begin() + static_cast<std::ptrdiff_t>(layer * static_cast<std::size_t>(high)));
    return part;
}

ImageScene image_of(const Path& input, const std::optional<Container>& container, const std::vector<double>& section_m) {
    if (!std::filesystem::is_directory(input)) {
        ImageScene scene = load_image(input, container, section_m);
        scene.image = cropped(scene.image, scene.section);
        return scene;
    }
    SliceStack stack = read_slices(input);
    ImageScene scene{.image = {.grid = stack.grid, .phase = std::move(stack.phase), .notes = {}},
                     .container = stack.container,
                     .section = stack.section};
    if (section_m.size() == 2) {
        scene.section = {section_m[0], section_m[1]};
        scene.image = cropped(scene.image, scene.section);
    }
    return scene;
}

}  // namespace

Json geometric_paper_stage(const Scene& scene, const TortuosityConfig& config, const Path& folder) {
    if (!scene.grains)
        throw UserError(
            "the exact dot method needs a packing",
            {.mend =
                 "make slices of the STL file and give their folder: porepack slices, then porepack tortuosity geometric_paper SLICES"});
    Json json = geometric_json(geometric_paper_exact(*scene.grains, scene.container, scene.section, config),
                               config.dot_pixel_m > 0.0 ? "pixels" : "exact", folder / "paths_geometric_paper.vtp");
    if (config.dot_pixel_m > 0.0) json["pixel_m"] = config.dot_pixel_m;
    return json;
}

Json geometric_paper_slices_stage(const Path& slices, const TortuosityConfig& config, const Path& folder) {
    const SliceStack stack = read_slices(slices);
    Json json = geometric_json(geometric_paper_on_slices(stack, config), "pixels", folder / "paths_geometric_paper_pixels.vtp");
    json["pixel_m"] = stack.grid.spacing_m[0];
    return json;
}

namespace {

// Of an OpenFOAM case that has run; it flows along the direction in which the mean velocity points.
Json hydraulic_foam_stage(const Path& folder, const std::vector<double>& section_m) {
    const Section section = section_m.size() == 2 ? Section{section_m[0], section_m[1]} : Section{-1e300, 1e300};
    double speed = 0.0;
    Vec3 mean = Vec3::Zero();
    for (const FoamCell& cell : read_foam_cells(folder)) {
        if (cell.centre_m.z() < section.z0 || cell.centre_m.z() > section.z1) continue;
        speed += cell.volume_m3 * cell.velocity.norm();
        mean += cell.volume_m3 * cell.velocity;
    }
    int axis = 2;
    const double along = mean.cwiseAbs().maxCoeff(&axis);
    if (!(along > 0.0)) throw NumericalError("nothing flows in this OpenFOAM case", {.where = folder.string()});
    return {{"kind", "hydraulic"},
            {"solver", "openfoam"},
            {"direction", std::string(1, "xyz"[axis])},
            {"tortuosity_hydraulic", speed / along},
            {"uncertainty", nullptr}};
}

}  // namespace

Json hydraulic_stage(const Path& flow_vti, const std::vector<double>& section_m) {
    if (std::filesystem::exists(flow_vti / "system" / "controlDict")) return hydraulic_foam_stage(flow_vti, section_m);
    const FlowImage flow = read_flow_image(flow_vti);
    Section section{-1e300, 1e300};
    if (section_m.size() == 2)
        section = {section_m[0], section_m[1]};
    else if (flow.notes.contains("section"))
        section = section_of_note(flow.notes.at("section"), flow_vti);
    const std::string direction = flow.notes.contains("direction") ? flow.notes.at("direction") : "z";
    return {{"kind", "hydraulic"},
            {"direction", direction},
            {"tortuosity_hydraulic", hydraulic_tortuosity(flow, section, static_cast<int>(axis_of(direction)))},
            {"uncertainty", nullptr}};
}

Json shortest_path_stage(const Scene& scene, const GeometryConfig& geometry, const TortuosityConfig& config, const Path& folder) {
    const VoxelPlan plan = plan_voxels(scene.container, scene.section, scene.voxel_size(geometry), 0.0, scene.grain_size_m);
    require_memory(shortest_path_memory_bytes(static_cast<double>(plan.grid.size())), "the search for the shortest ways",
                   "take a larger voxel size or a shorter section");
    const auto axis = static_cast<int>(axis_of(config.direction));
    const ShortestPathResult result = scene.grains
                                          ? shortest_path(*scene.grains, scene.container, scene.section, plan, scene.grain_size_m, axis)
                                          : shortest_path(voxelise(scene.solid(), scene.container, scene.section, plan), axis,
                                                          periodic_sides(scene.container, scene.section));
    return shortest_path_json(result, config.direction, scene.grains ? "exact" : "voxels", plan.voxel_size_m,
                              folder / "paths_shortest.vtp");
}

Json shortest_path_image_stage(const Path& input, const std::optional<Container>& container, const std::vector<double>& section_m,
                               const TortuosityConfig& config, const Path& folder) {
    const ImageScene scene = image_of(input, container, section_m);
    require_memory(shortest_path_memory_bytes(static_cast<double>(scene.image.grid.size())), "the search for the shortest ways",
                   "take a shorter section");
    return shortest_path_json(
        shortest_path(scene.image, static_cast<int>(axis_of(config.direction)), periodic_sides(scene.container, scene.section)),
        config.direction, "voxels", scene.image.grid.spacing_m[0], folder / "paths_shortest.vtp");
}

Json diffusive_stage(const Scene& scene, const GeometryConfig& geometry, const TortuosityConfig& config) {
    std::array<double, 3> sizes{}, values{};
    Json json;
    std::string missing;  // why there is no limit
    const auto axis = static_cast<int>(axis_of(config.direction));
    for (std::size_t grid = 0; grid < 3 && missing.empty(); ++grid) {
        const double asked = std::array{1.0, 1.5, 2.0}[grid] * scene.voxel_size(geometry);
        // A periodic box keeps whole numbers of voxels.
        const double side = scene.container.size_m.x();
        const double size = scene.container.any_periodic() ? side / std::max(1.0, std::round(side / asked)) : asked;
        if (grid > 0 && (size > scene.grain_size_m || size > 0.5 * scene.section.length())) {
            missing = "the voxels are too coarse for three grids";
            break;
        }
        const VoxelPlan plan = plan_voxels(scene.container, scene.section, size, 0.0, scene.grain_size_m);
        require_memory(diffusive_memory_bytes(static_cast<double>(plan.grid.size())), "diffusion on the voxels",
                       "take a larger voxel size or a shorter section");
        const PhaseImage image = voxelise(scene.solid(), scene.container, scene.section, plan);
        try {
            const DiffusiveResult result = diffusive_tortuosity(image, axis, periodic_sides(scene.container, scene.section));
            if (grid == 0) json = diffusive_json(result, config.direction);
            sizes[grid] = plan.voxel_size_m;
            values[grid] = result.value;
            json["grids"].push_back({{"voxel_size_m", plan.voxel_size_m}, {"tortuosity_diffusive", result.value}});
        } catch (const DoesNotPercolate&) {
            if (grid == 0) throw;
            missing = fmt::format("on voxels of {:.3g} m nothing leads through", plan.voxel_size_m);
        }
    }
    json["interval"] = nullptr;
    if (missing.empty() && sizes[1] > sizes[0] && sizes[2] > sizes[1]) {
        const DiffusiveLimit limit = diffusive_limit(sizes, values);
        json["tortuosity_diffusive"] = limit.value;
        json["interval"] = {std::max(1.0, limit.value - limit.half_width), limit.value + limit.half_width};
    } else {
        json["no_interval_because"] = missing.empty() ? "the grids do not differ" : missing;
    }
    return json;
}

Json diffusive_image_stage(const Path& input, const std::optional<Container>& container, const std::vector<double>& section_m,
                           const TortuosityConfig& config) {
    const ImageScene scene = image_of(input, container, section_m);
    require_memory(diffusive_memory_bytes(static_cast<double>(scene.image.grid.size())), "diffusion on the voxels",
                   "take a shorter section");
    Json json = diffusive_json(
        diffusive_tortuosity(scene.image, static_cast<int>(axis_of(config.direction)), periodic_sides(scene.container, scene.section)),
        config.direction);
    json["interval"] = nullptr;
    json["voxel_size_m"] = scene.image.grid.spacing_m[0];
    return json;
}

// Measured: 34 s and 22 s for 21 million voxels, the latter with its two coarser grids.
Expectation expect_tortuosity(const std::string& kind, double cells) {
    Expectation expected{.text = fmt::format("{:.2g} voxels", cells)};
    if (kind == "shortest_path") {
        expected.memory_bytes = shortest_path_memory_bytes(cells);
        expected.wall_time_s = 1.6e-6 * cells;
    } else if (kind == "diffusive") {
        expected.memory_bytes = diffusive_memory_bytes(cells);
        expected.wall_time_s = 1.1e-6 * cells;
    } else {
        expected.wall_time_s = 3.0;
    }
    return expected;
}

}  // namespace porepack
