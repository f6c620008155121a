#include "inputs/image_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "inputs/uses.hpp"
#include "scans/ball_walls.hpp"
#include "scans/doubts.hpp"
#include "scans/find_tube.hpp"
#include "scans/gray_input.hpp"
#include "scans/layer_profile.hpp"
#include "scans/phases.hpp"

namespace porepack::inputs {

Container box_of(const imaging::VolumeHeader& image) {
    Vec3 size;
    for (const int axis : {0, 1, 2}) {
        const auto a = static_cast<std::size_t>(axis);
        size[axis] = static_cast<double>(image.voxels[a]) * image.spacing_m[a];
    }
    return vessels::make_box(size);
}

namespace {

// --container, the image's own, or the box that the image fills.
Container container_shown_by(const imaging::VolumeHeader& image, const std::optional<Container>& given, const Path& file) {
    const auto note = image.notes.find("container");
    if (given && note == image.notes.end()) {
        for (const int axis : {0, 1}) {
            const auto a = static_cast<std::size_t>(axis);
            const double image_size = static_cast<double>(image.voxels[a]) * image.spacing_m[a],
                         size = given->high()[axis] - given->low()[axis];
            if (image_size > 1.05 * size)
                log_warning(fmt::format("{}: the image is {:.4g} m wide along {}, the container {:.4g} m: what lies beyond is left out",
                                        file.string(), image_size, "xyz"[axis], size));
        }
        return *given;
    }
    if (note != image.notes.end()) {
        const Json json = Json::parse(note->second, nullptr, false);
        if (json.is_discarded())
            throw UserError("the image's field data `container` is not JSON: " + note->second,
                            {.where = file.string(), .fix = container_flag()});
        const Container own = container_from_json(json, file.string());
        if (given && to_json(*given) != to_json(own))
            throw UserError("the image states another container than the one that is given: " + note->second,
                            {.where = file.string(), .fix = "remove --container, or [container]"});
        return own;
    }
    return box_of(image);
}

// What lies outside the vessel is no pore, whatever the image shows there.
void leave_out_outside(PhaseImage& image, const Container& container) {
    if (container.vessel().fills_bounds()) return;
    const Grid& grid = image.grid;
    std::vector<Interval> inside;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            container.vessel().column(grid.centre(0, i), grid.centre(1, j), inside);
            if (is_whole_line(inside)) continue;
            for (int k = 0; k < grid.cells[2]; ++k)
                if (!geometry::contains(inside, grid.centre(2, k))) image.phase[grid.index(i, j, k)] = Phase::outside;
        }
}

}  // namespace

bool has_gray_walls(const imaging::ImageConfig& config) {
    if (config.walls == imaging::ImageWalls::gray && !config.threshold)
        throw UserError("gray walls need a threshold", {.where = "[image], --image-walls", .fix = "--image-threshold volume"});
    return (config.walls == imaging::ImageWalls::automatic || config.walls == imaging::ImageWalls::gray) && config.threshold;
}

namespace {

void warn_of_thin_parts(const PhaseImage& image, const Container& container, const Path& file) {
    constexpr double few = 0.02;
    const scans::ThinParts thin = scans::thin_parts(image, container.periodic());
    if (std::max(thin.solid, thin.pores) > few)
        log_warning(fmt::format(
            "{}: {:.0f} % of the solid and {:.0f} % of the pores are one or two voxels wide: their walls are not known, and k may be "
            "farther off than its interval says",
            file.string(), 100.0 * thin.solid, 100.0 * thin.pores));
}

// A key that would change nothing is an error.
void require_effect(const imaging::ImageConfig& config, bool own_fractions, const Path& file) {
    const auto refuse = [&](bool given, const char* key, const char* why) {
        if (given)
            throw UserError(fmt::format("`{}` has no effect: {}", key, why),
                            {.where = file.string() + ": [image], --image-...", .fix = "remove it"});
    };
    const bool by_values = !config.pore.empty();
    refuse(by_values && config.threshold, "threshold", "the values of the pores are given");
    const char* why = own_fractions ? "the image has its threshold and solid fractions"
                      : by_values   ? "the values of the pores are given"
                                    : "the walls lie half-way between voxels";
    const bool gray = !own_fractions && !by_values && has_gray_walls(config);
    refuse(!gray && config.smoothing_voxels >= 0.0, "smoothing_voxels", why);
    refuse(!gray && !config.gray_levels.empty(), "gray_levels", why);
    refuse((own_fractions || by_values) && config.pore_side != imaging::PoreSide::below, "pore_side", why);
    refuse((own_fractions || by_values) && config.walls == imaging::ImageWalls::gray, "walls", why);
    refuse(own_fractions && config.walls != imaging::ImageWalls::automatic, "walls", why);
    refuse(own_fractions && config.find_container, "find_container", "the image states its container");
}

}  // namespace

ImageInput read_image(const Path& file, const imaging::ImageConfig& config, const std::optional<Container>& container) {
    return read_image(imaging::open_volume(file, config), config, container, file);
}

ImageInput read_image(const imaging::VolumeSource& source, const imaging::ImageConfig& config, const std::optional<Container>& container,
                      const Path& file) {
    const imaging::VolumeHeader& header = source.header;
    ImageInput input;
    std::optional<std::array<double, 2>> axis;
    if (config.find_container) {
        if (container) throw UserError("a given container and --image-find-container exclude each other", {.where = file.string()});
        const scans::Tube tube = scans::find_tube(source, config.pore_side, file.string());
        axis = {tube.x_voxels, tube.y_voxels};
        const double diameter = 2.0 * tube.radius_voxels * header.spacing_m[0];
        input.container = vessels::make_cylinder(diameter, static_cast<double>(header.voxels[2]) * header.spacing_m[2]);
        log_info("container: a tube of {:.5g} m, its axis at voxel {:.2f}, {:.2f} (edges {:.2g} voxels off)", diameter, tube.x_voxels,
                 tube.y_voxels, tube.residual_voxels);
    } else {
        input.container = container_shown_by(header, container, file);
        vessels::require_prism(input.container, "an image");
    }
    const bool own_fractions = header.own_fractions && !config.threshold && config.pore.empty();
    input.file = {.format = header.format,
                  .voxels = header.voxels,
                  .voxel_size_m = header.spacing_m,
                  .voxel_size_from = header.size_source,
                  .orientation = header.orientation};
    input.own = own_fractions || (header.own_phases && header.notes.contains("container"));
    require_effect(config, own_fractions, file);
    if (own_fractions || has_gray_walls(config)) {
        const GrayInput gray = own_fractions ? read_own_gray(source, input.container, file.string())
                                             : read_gray(source, config, input.container, file.string(), axis);
        input.gray = gray.solid;
        input.pores =
            fmt::format("values {} {:.6g}", config.pore_side == imaging::PoreSide::below ? "below" : "above", gray.notes.threshold);
        input.gray_notes = gray.notes;
        if (config.find_container && !gray.notes.tube_removed)
            throw UserError("a tube was found, but nothing as dense as a wall lies all around it",
                            {.where = file.string(), .fix = "--container cylinder:D,H"});
        return input;
    }
    if (config.find_container)
        throw UserError("a container is found with gray walls only", {.where = file.string(), .fix = "--image-threshold volume"});
    imaging::ImageConfig levels = config;
    if (config.threshold) levels.threshold = threshold_value(source, config, input.container, file.string());
    scans::SegmentedImage found = scans::segmented(source, levels, file.string());
    input.image = std::move(found.image);
    if (!input.image.notes.contains("container")) place(input.image.grid, input.container);  // else it is in its place
    leave_out_outside(input.image, input.container);
    input.pores = found.pore_level;
    if (config.walls == imaging::ImageWalls::balls) {
        require_memory(scans::bytes_per_voxel_of_balls * static_cast<double>(input.image.grid.size()), "walls of the largest balls",
                       "--image-walls half_way, porepack image crop, or porepack image bin");
        warn_of_thin_parts(input.image, input.container, file);
        const GrayInput balls = scans::walls_of_balls(input.image, input.container);
        input.gray = balls.solid;
        input.gray_notes = balls.notes;
        input.image = {};
        return input;
    }
    input.image.notes["container"] = to_json(input.container).dump();
    return input;
}

}  // namespace porepack::inputs
