#include "analysis/fit_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "analysis/slice_picture.hpp"
#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "core/table.hpp"
#include "geometry/gray_filters.hpp"
#include "inputs/image_input.hpp"
#include "packing/grains.hpp"
#include "scans/detect.hpp"
#include "scans/find_tube.hpp"
#include "scans/fitted_model.hpp"
#include "scans/gray_input.hpp"
#include "scans/large_scan.hpp"
#include "scans/refine.hpp"

namespace porepack::analysis {
namespace {

constexpr double wanted_voxels = 6.0;  ///< per diameter, for the search
double volume_of_parts_m3(const std::vector<shapes::Capsule>& capsules) {
    double volume = 0.0;
    for (const shapes::Capsule& c : capsules)
        volume += std::numbers::pi * c.radius * c.radius * ((c.b - c.a).norm() + 4.0 / 3.0 * c.radius);
    return volume;
}

// Relative change of the solid's volume from the given sizes to the fitted ones. Where capsules of a grain overlap, volume counts twice:
// this is right to first order where overlaps grow like the rest.
double solid_change(const std::vector<shapes::Shape>& shapes, const Refined& found) {
    double given = 0.0, fitted = 0.0;
    for (const auto& grain : found.grains) {
        const auto s = static_cast<std::size_t>(grain.shape);
        const Common::OfShape& sizes = found.common.shapes[s];
        given += volume_of_parts_m3(shapes[s].capsules);
        fitted += volume_of_parts_m3(resized(shapes[s].capsules, sizes.radius_change_m.value, sizes.length_factor.value));
    }
    return given > 0.0 ? fitted / given - 1.0 : 0.0;
}

Packing packing_of(const Container& container, const std::vector<shapes::Shape>& shapes, const Refined& found, bool fitted_sizes) {
    Packing packing{.container = container, .shapes = shapes, .bodies = {}};
    packing.container = container.with_cut_ends();
    for (std::size_t s = 0; s < shapes.size() && fitted_sizes; ++s) {
        const Common::OfShape& sizes = found.common.shapes[s];
        packing.shapes[s].capsules = resized(shapes[s].capsules, sizes.radius_change_m.value, sizes.length_factor.value);
        packing.shapes[s].cavity_points.clear();
        packing.shapes[s].void_cells = {};
        if (packing.shapes[s].cavity == shapes::Cavity::filled) find_cavities(packing.shapes[s]);
    }
    for (const FittedGrain& grain : found.grains) packing.bodies.push_back({grain.shape, grain.pose.position_m, grain.pose.orientation});
    return packing;
}

Table grain_table(const std::vector<shapes::Shape>& shapes, const Refined& found) {
    Table table(
        {"body", "shape", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "residual", "position_uncertainty_m", "end_uncertainty_m", "cut"});
    for (std::size_t g = 0; g < found.grains.size(); ++g) {
        const FittedGrain& grain = found.grains[g];
        const auto& q = grain.pose.orientation;
        table.add(static_cast<long>(g), shapes[grain.shape].id, grain.pose.position_m.x(), grain.pose.position_m.y(),
                  grain.pose.position_m.z(), q.w(), q.x(), q.y(), q.z(), grain.residual, grain.position_error_m, grain.end_error_m,
                  grain.cut ? "yes" : "no");
    }
    return table;
}

// The slice through the middle: gray values with the fitted outlines, orange where solid is not explained, blue where a grain should be.
Picture fit_picture(const GrayImage& image, const std::vector<std::uint8_t>& model) {
    const auto at = [&](int i, int k) { return image.grid.index(i, middle_row(image.grid), k); };
    return slice_picture(
        "fit.png", image.grid,
        [&](int i, int k) {
            const double missing = image.at(at(i, k)) - model[at(i, k)] / 255.0;
            if (missing > 0.4) return Colour{230, 159, 0};
            if (missing < -0.4) return Colour{0, 114, 178};
            return gray_colour(image.at(at(i, k)));
        },
        [&](int i, int k) { return model[at(i, k)] > 127 ? 1 : 0; }, {86, 180, 233});
}

// Voxels of solid that no grain explains, in pieces. Pieces at the first and the last layer are parts of grains of which too little is
// shown; they do not count among the others.
struct Unexplained {
    double solid_voxels = 0.0, inside = 0.0, at_ends = 0.0, largest_piece = 0.0;
    double missing = 0.0;                ///< grain without solid
    int complete_from = 0, complete_to;  ///< layers that no larger piece from the ends reaches
};
Unexplained unexplained_of(const GrayImage& image, const Container& container, const std::vector<std::uint8_t>& model,
                           double speck_voxels) {
    const Grid& grid = image.grid;
    Unexplained found{.complete_to = grid.cells[2]};
    std::vector<std::uint8_t> open(model.size(), 0);
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            if (!container.contains_column(grid.centre(0, i), grid.centre(1, j))) continue;
            for (int k = 0; k < grid.cells[2]; ++k) {
                const std::size_t cell = grid.index(i, j, k);
                const double value = image.at(cell), fitted = model[cell] / 255.0;
                found.solid_voxels += value > 0.5 ? 1.0 : 0.0;
                if (value - fitted > 0.5) open[cell] = 1;
                if (fitted - value > 0.5) found.missing += 1.0;
            }
        }
    // Connected pieces by a flood fill with a stack; a voxel is cleared when it is pushed, so that it is pushed once.
    std::vector<std::size_t> stack;
    for (std::size_t start = 0; start < open.size(); ++start) {
        if (open[start] == 0) continue;
        double size = 0.0;
        int lowest = grid.cells[2], highest = 0;
        open[start] = 0;
        stack = {start};
        while (!stack.empty()) {
            const std::size_t cell = stack.back();
            stack.pop_back();
            size += 1.0;
            grid.for_neighbours(cell, [&](std::size_t other) {
                if (open[other] == 0) return;
                open[other] = 0;
                stack.push_back(other);
            });
            const int k = grid.place(cell)[2];
            lowest = std::min(lowest, k);
            highest = std::max(highest, k);
        }
        const bool at_bottom = lowest == 0, at_top = highest + 1 == grid.cells[2], at_end = at_bottom || at_top;
        // Where a larger piece is missing at an end, the packing is complete only beyond it.
        if (at_bottom && size > speck_voxels) found.complete_from = std::max(found.complete_from, highest + 1);
        if (at_top && size > speck_voxels) found.complete_to = std::min(found.complete_to, lowest);
        (at_end ? found.at_ends : found.inside) += size;
        if (!at_end) found.largest_piece = std::max(found.largest_piece, size);
    }
    return found;
}

double solid_volume(const GrayImage& image, const Container& container) {
    const Grid& grid = image.grid;
    double count = 0.0;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i)
            if (container.contains_column(grid.centre(0, i), grid.centre(1, j)))
                for (int k = 0; k < grid.cells[2]; ++k) count += image.at(grid.index(i, j, k)) > image.level ? 1.0 : 0.0;
    return count * std::pow(grid.spacing_m[0], 3.0);
}

std::vector<ShapePoints> mirrored_points(std::vector<shapes::Shape> shapes) {
    std::vector<ShapePoints> points;
    for (shapes::Shape& shape : shapes) {
        for (shapes::Capsule& capsule : shape.capsules)
            for (shapes::Vec3* end : {&capsule.a, &capsule.b}) end->x() = -end->x();
        shape.cavity_points.clear();
        shape.void_cells = {};
        if (shape.cavity == shapes::Cavity::filled) find_cavities(shape);
        points.push_back(points_of(shape));
    }
    return points;
}

// What a reader must know before the packing is used.
std::vector<std::string> doubts_of(const Refined& found, const Unexplained& rest, const std::vector<ShapePoints>& points,
                                   const std::vector<shapes::Shape>& shapes, double smallest_voxels, const Overlaps& overlaps) {
    std::vector<std::string> doubts;
    if (rest.inside > 0.01 * rest.solid_voxels)
        doubts.push_back(fmt::format("{:.1f} % of the solid, away from the ends, is not explained by the grains that were found",
                                     100.0 * rest.inside / rest.solid_voxels));
    if (rest.missing > 0.01 * rest.solid_voxels)
        doubts.push_back(
            fmt::format("grains fill places that are not solid: {:.1f} % of the solid", 100.0 * rest.missing / rest.solid_voxels));
    if (rest.largest_piece > 0.3 * smallest_voxels)
        doubts.push_back(fmt::format("a piece of {:.2g} grain volumes is not explained: a grain of another shape, or a broken one",
                                     rest.largest_piece / smallest_voxels));
    for (std::size_t s = 0; s < shapes.size(); ++s) {
        const Common::OfShape& sizes = found.common.shapes[s];
        const double r = points[s].thinnest_radius_m;
        if (std::abs(sizes.length_factor.value - 1.0) > std::max(0.004, 3.0 * sizes.length_factor.uncertainty))
            doubts.push_back(
                fmt::format("the axes of {} are {:+.2f} % longer than given", shapes[s].id, 100.0 * (sizes.length_factor.value - 1.0)));
        if (std::abs(sizes.radius_change_m.value) > std::max(0.01 * r, 3.0 * sizes.radius_change_m.uncertainty))
            doubts.push_back(
                fmt::format("the radii of {} are {:+.2f} % larger than given", shapes[s].id, 100.0 * sizes.radius_change_m.value / r));
    }
    if (const double d = 2.0 * points[0].thinnest_radius_m; overlaps.largest_between_grains_m > largest_overlap_of_diameter * d)
        doubts.push_back(fmt::format("bodies {} and {} overlap by {:.2g} diameters", overlaps.grains[0], overlaps.grains[1],
                                     overlaps.largest_between_grains_m / d));
    return doubts;
}

// In the image, coarser where the scan is large. Throws UserError where there are none, or their mirror images.
std::vector<FittedGrain> search_all(const GrayImage& gray, const Scan& scan, const Container& container,
                                    const std::vector<ShapePoints>& points, const std::vector<shapes::Shape>& shapes,
                                    const std::string& name) {
    const auto search = [&](const std::vector<ShapePoints>& of) {
        // A new map for each search, because detect() changes it.
        DistanceMap map = distance_map(scan.search_bin > 1 ? averaged(gray, scan.search_bin) : gray);
        std::vector<FittedGrain> grains;
        for (const Found& one : detect(map, of)) grains.push_back({.shape = one.shape, .pose = one.pose, .cut = one.cut});
        return grains;
    };
    std::vector<FittedGrain> grains = search(points);
    double volume = 0.0;
    for (const FittedGrain& grain : grains) volume += points[grain.shape].volume_m3;
    // Less than half of the solid found: a stack in the wrong order shows mirror images, which a chiral shape does not fit. The mirrored
    // shapes are searched for to give the right advice.
    if (volume < 0.5 * solid_volume(gray, container)) {
        const std::size_t mirrored = search(mirrored_points(shapes)).size();
        if (mirrored > 2 * grains.size() + 2)
            throw UserError(
                fmt::format("the image shows mirror images of the grains: {} of them, and {} as given", mirrored, grains.size()),
                {.where = name, .fix = "--image-axes with a minus sign (xy-z) if the stack is in the wrong order"});
    }
    if (grains.empty())
        throw UserError("no grain of this shape was found",
                        {.where = name, .fix = "check shape, voxel size and threshold (porepack image segment shows what is solid)"});
    return grains;
}

// How many grains are cut, how well the poses of the others are known, and the sizes of all.
void add_poses(results::Fit& result, const std::vector<shapes::Shape>& shapes, const Refined& found) {
    std::vector<double> positions, ends;
    for (const FittedGrain& grain : found.grains) {
        if (grain.cut) {
            ++result.grains.cut;
            continue;
        }
        positions.push_back(grain.position_error_m);
        ends.push_back(grain.end_error_m);
    }
    if (!positions.empty()) {
        result.position_uncertainty_m = median(positions);
        result.end_uncertainty_m = median(ends);
    }
    for (std::size_t s = 0; s < shapes.size(); ++s)
        result.sizes.emplace_back(shapes[s].id, results::FittedSizes{.radius_change_m = found.common.shapes[s].radius_change_m,
                                                                     .length_factor = found.common.shapes[s].length_factor});
}

}  // namespace

Fitted fit_image(const VolumeSource& source, ImageConfig image, const std::optional<Container>& given,
                 const std::vector<shapes::Shape>& shapes, const std::string& name) {
    if (!image.threshold) image.threshold = imaging::ThresholdRule::volume;
    image.walls = ImageWalls::gray;
    std::vector<ShapePoints> points;
    double thinnest = 1e300, smallest = 1e300;
    for (const shapes::Shape& shape : shapes) {
        const ShapePoints& found = points.emplace_back(points_of(shape));
        thinnest = std::min(thinnest, found.thinnest_radius_m);
        smallest = std::min(smallest, found.volume_m3);
    }
    const Scan scan = open_scan(source, image, 2.0 * thinnest, name);
    const ImageInput input = read_image(scan.reduced(), image, given, name);
    const GrayNotes& notes = *input.gray_notes;
    const GrayImage& gray = *input.gray->image();
    const double h = gray.grid.spacing_m[0];
    Stopwatch watch;
    std::vector<FittedGrain> grains = search_all(gray, scan, input.container, points, shapes, name);
    const double seconds_of_search = watch.seconds();
    watch = {};
    Refined found = refine(gray, input.container, points, std::move(grains), Common{.blur_m = {notes.blur_voxels * h}});
    // The model is compared with the reduced image, so it is rendered with this image's blur, not with that of the full size.
    const double blur_of_picture_m = found.common.blur_m.value;
    if (scan.bin > 1) found = refine_at_full_size(scan, gray, notes, input.container, points, std::move(found), name);
    const double seconds_of_poses = watch.seconds();
    const std::size_t refined = found.grains.size();
    std::vector<double> residuals;
    for (const FittedGrain& grain : found.grains) residuals.push_back(grain.residual);
    const double usual = median(residuals);
    // What fits far worse than the others is none of these grains.
    std::erase_if(found.grains, [&](const FittedGrain& grain) { return grain.residual > std::max(0.1, 2.5 * usual); });
    const std::vector<std::uint8_t> model = rendered(gray.grid, points, found, blur_of_picture_m);
    Container container = input.container;
    std::array<double, 3> origin_m = gray.grid.origin_m;
    if (image.find_container) {  // again, without the grains: they shift the edge
        const Tube tube = find_tube(scan.reduced(), image.pore_side, name, model);
        container = vessels::make_cylinder(2.0 * tube.radius_voxels * h, container.height());
        const shapes::Vec3 axis(gray.grid.origin_m[0] + tube.x_voxels * h, gray.grid.origin_m[1] + tube.y_voxels * h, 0.0);
        for (FittedGrain& grain : found.grains) grain.pose.position_m -= axis;
        for (const std::size_t a : {0, 1}) origin_m[a] -= axis[static_cast<int>(a)];
        log_info("container: {:.5g} m without the grains, its axis moved by {:.2g} voxels", *container.tube_diameter(), axis.norm() / h);
    }
    const Unexplained rest = unexplained_of(gray, input.container, model, 0.01 * smallest / (h * h * h));

    const Packing packing = packing_of(container, shapes, found, image.fitted_sizes);
    const Overlaps overlaps = find_overlaps(packing);

    results::Fit result{.file = input.file,
                        .gray = notes,
                        .container = to_json(packing.container),
                        .image_origin_m = origin_m,
                        .grains = {.found = found.grains.size(), .dropped = refined - found.grains.size()},
                        .solid_change = solid_change(shapes, found),
                        .blur_m = found.common.blur_m,
                        .pores = found.common.pores,
                        .solid = found.common.solid,
                        .residual = found.residual,
                        .residual_median = usual,
                        .noise = notes.noise,
                        .unexplained_solid = rest.inside / rest.solid_voxels,
                        .unexplained_solid_at_ends = rest.at_ends / rest.solid_voxels,
                        .grain_without_solid = rest.missing / rest.solid_voxels,
                        .largest_overlap_m = overlaps.largest_between_grains_m,
                        .contacts = overlaps.contacts,
                        .doubts = doubts_of(found, rest, points, shapes, smallest / (h * h * h), overlaps),
                        .search_s = seconds_of_search,
                        .poses_s = seconds_of_poses};
    add_poses(result, shapes, found);
    if (const Section complete{rest.complete_from * h, rest.complete_to * h}; complete.length() > 2.0 * h) {
        result.section_m = complete.interval();
        result.porosity = porosity(Grains(packing), packing.container, complete).value;
    }
    for (const std::string& doubt : result.doubts) log_warning(fmt::format("{}: {}", name, doubt));
    return {.outcome = {result, {.tables = {{"grains.csv", grain_table(shapes, found)}}, .pictures = {fit_picture(gray, model)}}},
            .packing = packing};
}

Fitted fit_image(const Path& file, const ImageConfig& image, const std::optional<Container>& container,
                 const std::vector<shapes::Shape>& shapes) {
    return fit_image(open_volume(file, image), image, container, shapes, file.string());
}

results::Fit written(const Fitted& fitted, const Path& folder) {
    write_packing(folder / "packing.json", fitted.packing);
    return written(fitted.outcome, folder);
}

// From measurements (docs/images.md).
Expectation expect_fit(double voxels) {
    return {.text = fmt::format("grains in {:.2g} voxels", voxels), .memory_bytes = 15.0 * voxels, .wall_time_s = 6e-6 * voxels};
}

}  // namespace porepack::analysis
