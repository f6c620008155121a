#include "analysis/tortuosity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/members_json.hpp"
#include "core/sides.hpp"
#include "inputs/pore_space_input.hpp"
#include "io/image.hpp"
#include "io/stl.hpp"
#include "openfoam/foam_field.hpp"
#include "scans/gray_input.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack::analysis {
namespace {

std::vector<io::Line> lines_of(const std::vector<std::vector<Vec3>>& paths) {
    std::vector<io::Line> lines;
    for (const auto& path : paths) {
        lines.emplace_back();
        for (const Vec3& point : path) lines.back().push_back({point.x(), point.y(), point.z()});
    }
    return lines;
}

Outcome<results::GeometricPaper> found_of(const GeometricPaperResult& result, const std::string& geometry, const std::string& paths_vtp) {
    return {{.geometry = geometry,
             .tortuosity = result.value,
             .standard_error = result.standard_error,
             .standard_deviation = result.standard_deviation,
             .paths = result.paths,
             .slices = result.slices,
             .rejections_per_point = result.rejections_per_point,
             .paths_file = paths_vtp},
            {.paths = {{paths_vtp, {lines_of(result.paths_m)}}}}};
}

// The lower bound of isotropic media on the tortuosity factor (Hashin & Shtrikman 1962).
std::optional<std::string> below_isotropic_limit(const DiffusiveEstimate& estimate) {
    const double limit = 0.5 * (3.0 - estimate.finest.porosity),
                 highest = estimate.interval() ? estimate.interval()->high : estimate.value();
    if (highest >= limit) return std::nullopt;
    return fmt::format(
        "below (3 - porosity)/2 = {:.4g}, which no isotropic packing of grains can be (Hashin & Shtrikman): the pores are straighter along "
        "this direction, or the section is too short",
        limit);
}

results::Diffusive result_of(const DiffusiveEstimate& estimate, Axis direction, Ends ends) {
    const DiffusiveResult& finest = estimate.finest;
    results::Diffusive result{.direction = direction,
                              .tortuosity_factor = estimate.value(),
                              .interval = estimate.interval(),
                              .relative_diffusivity = finest.porosity / estimate.value(),
                              .porosity = finest.porosity,
                              .porosity_flowing = finest.porosity_flowing,
                              .voxel_size_m = estimate.grids.front().voxel_size_m,
                              .iterations = finest.iterations,
                              .residual = finest.residual,
                              .flux_imbalance = finest.flux_imbalance,
                              .converged = finest.converged,
                              .ends = std::string(name_of(ends))};
    for (const DiffusiveGrid& grid : estimate.grids) result.grids.push_back({grid.voxel_size_m, grid.value});
    if (!estimate.no_limit_because.empty()) result.no_interval_because = estimate.no_limit_because;
    result.note = below_isotropic_limit(estimate);
    return result;
}

// What gray levels and blur may have done to the value, on the second finest grid, as for k; beyond the interval of the grids, on either
// side. Blur closes the pores around contacts, which makes the value too large; a second blur does not show it. Their part of
// sigma / d (value - 1) was 1.1 on poured tetrapods and 3.1 to 4.8 on simple and body-centred cubic spheres in contact.
Sides gray_errors(const DiffusiveEstimate& estimate, const PoreSpace& space, Axis direction) {
    const GrayVariants variants = gray_variants(*space.gray(), space.container);
    const DiffusiveGrid& middle = estimate.grids.at(1);
    const auto change = [&](std::shared_ptr<const GraySolid> other) {
        const PoreSpace varied = with_gray(space, std::move(other));
        return std::abs(diffusive_tortuosity(varied, middle.voxel_size_m, direction, {.one_grid = true}).finest.value - middle.value);
    };
    const double level = variants.other_level ? change(variants.other_level) : 0.0;
    if (!variants.blurred) return {level, level};
    constexpr double closed_contacts = 5.5;
    const double blur = variants.blur_voxels * space.image_voxel_size_m / space.grain_size_m,
                 blurred = GrayVariants::blur_part * change(variants.blurred);
    return {level + std::max(blurred, closed_contacts * blur * (estimate.value() - 1.0)), level + blurred};
}

}  // namespace

results::Diffusive compute_diffusive_tortuosity(const PoreSpace& space, const GeometryConfig& geometry, Axis direction) {
    const Ends ends = direction == Axis::z && space.ends == Ends::in_situ ? Ends::in_situ : Ends::planes;
    const DiffusiveEstimate estimate = diffusive_tortuosity(space, space.voxel_size_m(geometry.voxel_size_m), direction);
    results::Diffusive result = result_of(estimate, direction, ends);
    if (!space.gray() || !estimate.limit) return result;
    try {
        const Sides gray = gray_errors(estimate, space, direction);
        const Interval grids = *estimate.interval();
        result.interval = Interval{std::max(1.0, grids.low - gray.below), grids.high + gray.above};
        result.interval_of_the_grids = grids;
    } catch (const DoesNotPercolate&) {
        result.interval.reset();
        result.no_interval_because = "with a little more blur, or another gray level, the pores do not percolate";
    }
    return result;
}

Outcome<results::ShortestPath> compute_shortest_path(const PoreSpace& space, const GeometryConfig& geometry, Axis direction) {
    const double voxel = space.voxel_size_m(geometry.voxel_size_m);
    const ShortestPathResult found = shortest_path(space, voxel, direction);
    const char* paths = "paths_shortest.vtp";
    return {{.direction = direction,
             .geometry = space.grains() ? "exact" : "voxels",
             .voxel_size_m = space.section_only().plan_at(voxel).voxel_size_m,
             .tortuosity = found.value,
             .standard_error = found.standard_deviation / std::sqrt(static_cast<double>(std::max(1L, found.starts))),
             .standard_deviation = found.standard_deviation,
             .minimum = found.minimum,
             .maximum = found.maximum,
             .starts = found.starts,
             .blocked_starts = found.blocked_starts,
             .paths_file = paths},
            {.paths = {{paths, {lines_of(found.paths_m), static_cast<int>(index_of(direction))}}}}};
}

Outcome<results::GeometricPaper> compute_geometric_paper(const SliceStack& stack, const TortuosityConfig& config) {
    auto found = found_of(geometric_paper_on_slices(stack, config), "pixels", "paths_geometric_paper_pixels.vtp");
    found.result.pixel_m = stack.grid.spacing_m[0];
    return found;
}

Outcome<results::GeometricPaper> compute_geometric_paper(const PoreSpace& space, const TortuosityConfig& config) {
    vessels::require_prism(space.container, "the paper's tortuosity");
    if (space.own_grid() || space.gray()) {  // its layers are the slices
        PhaseImage layers = space.section_only().voxelise_at(space.voxel_size_m(0.0));
        return compute_geometric_paper(
            SliceStack{.grid = layers.grid, .phase = std::move(layers.phase), .container = space.container, .section = space.section},
            config);
    }
    if (!space.grains())
        throw UserError("the exact dot method needs a packing, without menisci",
                        {.fix = "make slices and give their folder: porepack slices, then porepack tortuosity geometric_paper SLICES"});
    const bool on_pixels = config.dot_pixel_m > 0.0;
    auto found = found_of(geometric_paper_exact(*space.grains(), space.container, space.section, config), on_pixels ? "pixels" : "exact",
                          "paths_geometric_paper.vtp");
    if (on_pixels) found.result.pixel_m = config.dot_pixel_m;
    return found;
}

Outcome<Json> compute_tortuosity(TortuosityKind kind, const PoreSpace& space, const GeometryConfig& geometry,
                                 const TortuosityConfig& config) {
    const auto as_json = [](auto found) { return Outcome<Json>{json_of(found.result), std::move(found.files)}; };
    if (kind == TortuosityKind::geometric_paper) return as_json(compute_geometric_paper(space, config));
    if (kind == TortuosityKind::diffusive) return {json_of(compute_diffusive_tortuosity(space, geometry, config.direction))};
    return as_json(compute_shortest_path(space, geometry, config.direction));
}

results::HydraulicTortuosity compute_hydraulic_tortuosity(const Path& file, const std::vector<double>& section_m) {
    Section section{-1e300, 1e300};
    if (section_m.size() == 2) section = {section_m[0], section_m[1]};
    if (std::filesystem::exists(file / "system" / "controlDict")) {
        const FoamTortuosity result = hydraulic_tortuosity(read_foam_cells(file), section);
        return {.solver = "openfoam", .direction = result.axis, .tortuosity = result.value};
    }
    const FlowImage flow = read_flow_image(file);
    if (section_m.size() != 2 && flow.notes.contains("section")) section = inputs::section_of_note(flow.notes.at("section"), file);
    const std::string noted = flow.notes.contains("direction") ? flow.notes.at("direction") : "z";
    const Axis direction = choice_named<Axis>(noted).value_or(Axis::z);
    return {.direction = direction, .tortuosity = hydraulic_tortuosity(flow, section, static_cast<int>(direction))};
}

// Measured on 2 threads: 34 s for 21 million voxels; 1.3 to 3.8e-6 s per voxel with the two coarser grids, the more the denser the bed.
Expectation expect_tortuosity(TortuosityKind kind, double cells) {
    Expectation expected{.text = fmt::format("{:.2g} voxels", cells)};
    if (kind == TortuosityKind::shortest_path) {
        expected.memory_bytes = shortest_path_memory_bytes(cells);
        expected.wall_time_s = 1.6e-6 * cells;
    } else if (kind == TortuosityKind::diffusive) {
        expected.memory_bytes = diffusive_memory_bytes(cells);
        expected.wall_time_s = 2.5e-6 * cells;
    } else {
        expected.wall_time_s = 3.0;
    }
    return expected;
}

}  // namespace porepack::analysis
