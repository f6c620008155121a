#include "scans/gray_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "core/members_json.hpp"
#include "geometry/gray_filters.hpp"
#include "pore_space/gray_measures.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr double margin_voxels = 3.0;

using Axis = std::optional<std::array<double, 2>>;  // in voxels from the corner of the image; empty: its middle

// Columns of the image that lie inside a cylinder.
ColumnMask mask_of(const VolumeHeader& header, const Container& container, const Axis& axis) {
    const std::optional<double> tube = container.tube_diameter();
    if (!tube) return {};
    ColumnMask mask(static_cast<std::size_t>(header.layer()));
    const double radius = 0.5 * *tube - margin_voxels * header.spacing_m[0];
    std::size_t at = 0;
    for (std::int64_t j = 0; j < header.voxels[1]; ++j)
        for (std::int64_t i = 0; i < header.voxels[0]; ++i) {
            const double x =
                (static_cast<double>(i) + 0.5 - (axis ? (*axis)[0] : 0.5 * static_cast<double>(header.voxels[0]))) * header.spacing_m[0];
            const double y =
                (static_cast<double>(j) + 0.5 - (axis ? (*axis)[1] : 0.5 * static_cast<double>(header.voxels[1]))) * header.spacing_m[1];
            mask[at++] = std::hypot(x, y) < radius ? 1 : 0;
        }
    return mask;
}

double blurred_step(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

bool follows(const std::optional<imaging::Threshold>& threshold, imaging::ThresholdRule rule) {
    return threshold == imaging::Threshold(rule);
}

// Noise over contrast from second differences along z, whose median no edge reaches: of white noise they have the deviation sqrt(6).
double noise_of(const GrayImage& image) {
    const Grid& grid = image.grid;
    std::vector<double> differences;
    const std::size_t step = 1 + grid.size() / 2000000, layer = grid.index(0, 0, 1);
    for (std::size_t cell = layer; cell + layer < grid.size(); cell += step)
        differences.push_back(std::abs(image.at(cell - layer) - 2.0 * image.at(cell) + image.at(cell + layer)));
    constexpr double of_median = 0.6745;
    return differences.empty() ? 0.0 : median(std::move(differences)) / (of_median * std::sqrt(6.0));
}

// Gray levels from voxels that the blur does not reach: the peaks of a histogram are shifted by partial volumes.
struct Levels {
    double pores = 0.0, solid = 1.0, pore_error = 0.0, solid_error = 0.0;
    bool pores_are_deep = false, solid_is_deep = false;  ///< some of their voxels are as far from walls as blur reaches
};
// The image moves into a shared pointer and back, because a GraySolid shares it: no copy is made.
Levels refine_levels(GrayImage& image, const Container& container, double blur_voxels) {
    const auto shared = std::make_shared<GrayImage>(std::move(image));
    // Three standard deviations of the blur with that of the voxel itself, 1/sqrt(12) = 0.3.
    const int depth = std::clamp(static_cast<int>(std::ceil(3.0 * std::hypot(blur_voxels, 0.3))), 1, 12);
    const Plateaus found = plateaus(GraySolid(shared, container), container, depth);
    image = std::move(*shared);
    Levels levels;
    if (found.pores) {
        levels.pores = found.pores->value;
        levels.pore_error = found.pores->error;
        levels.pores_are_deep = found.pores->depth_voxels == depth;
    }
    if (found.solid) {
        levels.solid = found.solid->value;
        levels.solid_error = found.solid->error;
        levels.solid_is_deep = found.solid->depth_voxels == depth;
    }
    rescale(image, levels.pores, levels.solid);
    return levels;
}

}  // namespace

// A tube that attenuates like the grains would join them and count as solid. Blur is linear, so the blurred tube can be subtracted.
bool remove_tube(GrayImage& image, const Container& container, double blur_voxels) {
    const std::optional<double> diameter = container.tube_diameter();
    if (!diameter) return false;
    const Grid& grid = image.grid;
    const double h = grid.spacing_m[0], radius = 0.5 * *diameter / h;
    const double width = std::sqrt(blur_voxels * blur_voxels + 1.0 / 12.0);
    std::vector<double> wall;
    const auto distance = [&](int i, int j) { return std::hypot(grid.centre(0, i), grid.centre(1, j)) / h; };
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i)
            if (const double r = distance(i, j); r > radius + 2.5 * width && r < radius + 2.5 * width + 2.0)
                for (int k = 0; k < grid.cells[2]; k += 1 + grid.cells[2] / 64) wall.push_back(image.at(grid.index(i, j, k)));
    // A wall is closed: nearly all of the ring around the container is as dense.
    const double tube = wall.empty() ? 0.0 : median(wall);
    const auto thin = std::count_if(wall.begin(), wall.end(), [&](double value) { return value < 0.5 * tube; });
    const bool visible = tube > 0.2 && static_cast<double>(thin) < 0.05 * static_cast<double>(wall.size());
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            // Up to three widths beyond the wall, the blurred edge of a visible tube is subtracted. Farther out, all voxels are pores.
            const double r = distance(i, j), part = blurred_step((r - radius) / width);
            if (part < 1e-6 || (!visible && r < radius + 3.0 * width)) continue;
            for (int k = 0; k < grid.cells[2]; ++k) {
                const std::size_t cell = grid.index(i, j, k);
                image.packed[cell] = GrayImage::pack(r > radius + 3.0 * width ? 0.0 : image.at(cell) - tube * part);
            }
        }
    return visible;
}

void place(Grid& grid, const Container& container, const Axis& on_axis) {
    const shapes::Vec3 middle = 0.5 * (container.low() + container.high());
    for (const int axis : {0, 1}) {
        const auto a = static_cast<std::size_t>(axis);
        grid.origin_m[a] = middle[axis] - (on_axis ? (*on_axis)[a] : 0.5 * grid.cells[a]) * grid.spacing_m[a];
    }
    grid.origin_m[2] = 0.0;
}

// The steps depend on each other in this order. The peaks of the histogram give solid fractions; their noise decides the smoothing; the
// blur is measured on the smoothed image. The blur tells how deep a voxel must lie to show its phase undisturbed, and thus refines the
// levels. With final levels the tube is subtracted; a threshold that keeps the volume follows last, because the tube would count as solid.
GrayInput read_gray(const VolumeSource& source, const ImageConfig& config, const Container& container, const std::string& where,
                    const Axis& axis) {
    if (!config.threshold) throw UserError("gray walls need a threshold", {.where = where, .fix = "--image-threshold volume"});
    const bool given = config.gray_levels.size() == 2;
    GrayLevels levels;
    if (given) {
        levels.pore = config.gray_levels[0];
        levels.solid = config.gray_levels[1];
        levels.otsu = levels.half_level();
        if (levels.pore == levels.solid || (levels.pore > levels.solid) != (config.pore_side == PoreSide::above))
            throw UserError(fmt::format("the gray levels {:g} of pores and {:g} of solid do not fit pore_side", levels.pore, levels.solid),
                            {.where = "[image], --image-gray-levels",
                             .fix = "pores first, then solid; --image-pore-side above where pores are brighter"});
        if (follows(config.threshold, imaging::ThresholdRule::otsu))
            throw UserError("gray levels have no effect on Otsu's threshold", {.where = "[image], --image-gray-levels"});
    } else {
        levels = fit_gray_levels(source, config.pore_side, mask_of(source.header, container, axis), where);
    }
    if (levels.only_two_values && config.walls == ImageWalls::automatic)
        throw UserError(
            fmt::format("the image has two values, {:g} and {:g}: it is segmented, and has no gray values", levels.pore, levels.solid),
            {.where = where, .fix = fmt::format("--image-pore {:g} (half-way walls), or --image-walls gray", levels.pore)});
    for (const std::int64_t voxels : source.header.voxels)
        if (voxels < 4)
            throw UserError(
                fmt::format("the image has {} x {} x {} voxels", source.header.voxels[0], source.header.voxels[1], source.header.voxels[2]),
                {.where = where, .allowed = "4 or more along each axis for walls from gray values"});
    GrayNotes notes{.pore_level = levels.pore, .solid_level = levels.solid};
    auto image = std::make_shared<GrayImage>(solid_fractions(source, levels, where));
    notes.noise = given ? noise_of(*image) : levels.noise();
    place(image->grid, container, axis);
    notes.smoothing_voxels = config.smoothing_voxels >= 0.0 ? config.smoothing_voxels : needed_smoothing(notes.noise);
    smooth(*image, notes.smoothing_voxels, container.periodic());
    notes.blur_voxels = measure_gray(GraySolid(image, container), container).blur;
    // Levels that the user gives count as known to 0.2 % of the contrast.
    constexpr double error_of_given = 0.002;
    const Levels fine =
        given ? Levels{.pore_error = error_of_given, .solid_error = error_of_given} : refine_levels(*image, container, notes.blur_voxels);
    notes.levels_given = given;
    const double contrast = levels.solid - levels.pore;
    notes.pore_level = levels.pore + fine.pores * contrast;
    notes.solid_level = levels.pore + fine.solid * contrast;
    const auto fraction_of = [&](double value) { return (value - notes.pore_level) / (notes.solid_level - notes.pore_level); };
    notes.tube_removed = remove_tube(*image, container, notes.blur_voxels);
    notes.keeps_volume = follows(config.threshold, imaging::ThresholdRule::volume);
    if (const double* value = std::get_if<double>(&*config.threshold))
        notes.level = fraction_of(*value);
    else if (follows(config.threshold, imaging::ThresholdRule::otsu))
        notes.level = fraction_of(levels.otsu);
    else if (notes.keeps_volume)
        notes.level = volume_keeping_level(GraySolid(image, container), container);
    if (!(notes.level > 0.02 && notes.level < 0.98))
        throw UserError(fmt::format("the threshold is not between the gray levels of pores ({:g}) and solid ({:g})", notes.pore_level,
                                    notes.solid_level),
                        {.where = where, .fix = "--image-threshold volume, or --image-pore-side above where the pores are brighter"});
    if (notes.noise > 0.2)
        log_warning(fmt::format("{}: the noise is {:.0f} % of the difference between pores and solid", where, 100.0 * notes.noise));
    if (!given && !(fine.pores_are_deep && fine.solid_is_deep))
        log_warning(fmt::format("{}: blur reaches all voxels of the {}, so their gray level is uncertain: give it (--image-gray-levels)",
                                where, fine.pores_are_deep ? "solid" : "pores"));
    image->level = notes.level;
    notes.threshold = notes.pore_level + notes.level * (notes.solid_level - notes.pore_level);
    const auto solid = std::make_shared<const GraySolid>(image, container);
    const GrayMeasures found = measure_gray(*solid, container);
    notes.slope = found.slope;
    // The fraction f = (g - pores) / (solid - pores) changes by -(1 - f) and -f per unit error of the two levels.
    notes.fraction_error = std::hypot((1.0 - found.gray_fraction) * fine.pore_error, found.gray_fraction * fine.solid_error);
    image->notes["container"] = to_json(container).dump();
    if (notes.tube_removed) image->notes["shows_wall"] = "true";
    image->notes["gray"] = json_of(notes).dump();
    return {solid, notes};
}

GrayInput read_own_gray(const VolumeSource& source, const Container& container, const std::string& where) {
    GrayInput input;
    const Json json = Json::parse(source.header.notes.at("gray"), nullptr, false);
    if (json.is_discarded() || !json.is_object())
        throw UserError("the image's field data `gray` is not JSON", {.where = where, .fix = "make the image again from the scan"});
    try {
        input.notes = from_json_members<GrayNotes>(json);
    } catch (const UserError&) {
        throw UserError("the image's field data `gray` has not the expected content",
                        {.where = where, .fix = "make the image again from the scan"});
    }
    const GrayNotes& notes = input.notes;
    const double level = (notes.threshold - notes.pore_level) / (notes.solid_level - notes.pore_level);
    const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
    if (!(std::abs(level - notes.level) < 1e-3 && within(notes.level, 0.02, 0.98) && within(notes.blur_voxels, 0.0, 20.0) &&
          within(notes.noise, 0.0, 1.0) && within(notes.fraction_error, 0.0, 0.2)))
        throw UserError(
            "the image's field data `gray` contradicts itself, or has values that are not possible",
            {.where = where,
             .allowed = "level 0.02 to 0.98, which is (threshold - pore_level) / (solid_level - pore_level); blur up to 20 voxels",
             .fix = "make the image again from the scan"});
    auto image = std::make_shared<GrayImage>(solid_fractions(source, {.pore = 0.0, .solid = 1.0}, where));
    image->level = input.notes.level;
    input.solid = std::make_shared<const GraySolid>(image, container);
    return input;
}

double threshold_value(const VolumeSource& source, const ImageConfig& config, const Container& container, const std::string& where) {
    if (const double* value = std::get_if<double>(&config.threshold.value())) return *value;
    if (follows(config.threshold, imaging::ThresholdRule::volume))
        throw UserError("the threshold `volume` needs gray walls", {.where = where, .fix = "half_level or otsu, or --image-walls gray"});
    const GrayLevels levels = fit_gray_levels(source, config.pore_side, mask_of(source.header, container, {}), where);
    return follows(config.threshold, imaging::ThresholdRule::otsu) ? levels.otsu : levels.half_level();
}

GrayVariants gray_variants(const GraySolid& solid, const Container& container) {
    const auto notes = from_json_members<GrayNotes>(Json::parse(solid.image()->notes.at("gray")));
    const auto kept_level = [&](const GraySolid& other) {
        return std::make_shared<const GraySolid>(
            other.with_level(notes.keeps_volume ? volume_keeping_level(other, container) : solid.level()));
    };
    GrayVariants variants;
    const auto& cells = solid.image()->grid.cells;
    if (std::all_of(cells.begin(), cells.end(), [](int n) { return n >= 8 && n % 2 == 0; }))
        variants.averaged = kept_level(GraySolid(std::make_shared<GrayImage>(averaged(*solid.image(), 2)), container));
    // The solid fraction falls with the level (slope < 0): this level changes it by two standard errors.
    if (notes.fraction_error > 0.0 && notes.slope < 0.0)
        variants.other_level = std::make_shared<const GraySolid>(
            solid.with_level(std::clamp(solid.level() - 2.0 * notes.fraction_error / notes.slope, 0.05, 0.95)));
    if (notes.blur_voxels > 0.0) {
        auto image = std::make_shared<GrayImage>(*solid.image());
        // Variances add: smoothing with the image's own blur doubles its variance.
        smooth(*image, notes.blur_voxels, container.periodic());
        if (!notes.levels_given) (void)refine_levels(*image, container, std::numbers::sqrt2 * notes.blur_voxels);
        variants.blurred = kept_level(GraySolid(image, container));
        variants.blur_voxels = notes.blur_voxels;
    }
    return variants;
}

PoreSpace with_gray(const PoreSpace& space, std::shared_ptr<const GraySolid> other) {
    PoreSpace varied = space;
    varied.solid = std::move(other);
    return varied;
}

}  // namespace porepack::scans
