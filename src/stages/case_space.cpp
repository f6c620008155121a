// Container, packing and pore space of a case, as far as they exist.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <numbers>

#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "imaging/volume.hpp"
#include "inputs/image_input.hpp"
#include "inputs/mesh_grains.hpp"
#include "inputs/mesh_vessel.hpp"
#include "inputs/pore_space_input.hpp"
#include "pouring/pour.hpp"
#include "record/digest.hpp"
#include "record/resolved_config.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace fs = std::filesystem;

namespace {

// 4 volume / surface, as of a checked surface.
double grain_size_of(const geometry::TriangleSurface& surface) {
    double volume = 0.0, area = 0.0;
    for (const auto& triangle : surface.triangles) {
        const auto corner = [&](std::size_t c) {
            const auto& p = surface.points[static_cast<std::size_t>(triangle[c])];
            return Vec3(p[0], p[1], p[2]);
        };
        const Vec3 a = corner(0), normal = (corner(1) - a).cross(corner(2) - a);
        volume += a.dot(normal) / 6.0;
        area += 0.5 * normal.norm();
    }
    return area > 0.0 ? 4.0 * std::abs(volume) / area : 0.0;
}

}  // namespace

std::string solid_stage(const Case& c) {
    return c.from_image() ? "image" : c.from_surface() ? "stl" : "pack";
}

namespace {

// Menisci take a minute, and each stage asks for them: the last ones are kept.
PoreSpace space_with_menisci(const Path& packing, const InputOptions& options) {
    static std::mutex one_at_a_time;
    static std::string kept_key;
    static std::optional<PoreSpace> kept;
    const std::lock_guard lock(one_at_a_time);
    const std::string key = record::sha256_of_file(packing) + record::resolved_config(options.geometry).dump() +
                            record::resolved_config(options.section).dump();
    if (key != kept_key) {
        kept_key.clear();
        kept = load_pore_space(packing, options);
        kept_key = key;
    }
    return *kept;
}

}  // namespace

PoreSpace case_pore_space(const Case& c) {
    if (c.from_image())
        return load_pore_space(c.stage_folder("image") / image_file(c), {.geometry = c.settings.geometry, .section = c.settings.section});
    const InputOptions options{.container = case_container(c), .geometry = c.settings.geometry, .section = c.settings.section};
    const Path surface = c.stage_folder("stl") / "solid.stl";
    if (c.from_surface()) return load_pore_space(surface, options);
    const Path packing = c.stage_folder("pack") / "packing.json";
    return c.settings.geometry.closing_radius_m > 0.0 ? space_with_menisci(packing, options) : load_pore_space(packing, options);
}

std::vector<ShapeShare> case_shapes(const Case& c) {
    return make_shapes(inputs::with_mesh_grains(c.settings.shape, c.folder));
}

Container case_container(const Case& c) {
    const bool shrinks = c.settings.packing.fill == Fill::scatter;  // the case gives the box in which the grains are scattered
    if (!c.from_fit() && !shrinks) return inputs::make_container(c.settings.container, c.folder);
    if (const Path made = c.stage_folder("pack") / "packing.json"; fs::exists(made)) return read_packing(made).container;
    if (shrinks) return inputs::make_container(c.settings.container, c.folder);
    if (const auto given = container_of_image(c)) return *given;
    return box_of(imaging::open_volume(c.resolve(c.settings.image.file), c.settings.image).header);
}

bool has_packing(const Case& c) {
    const Path manifest = c.stage_folder("pack") / "manifest.json";
    return !c.from_surface() && !c.from_image() && fs::exists(manifest) && fs::exists(c.stage_folder("pack") / "packing.json") &&
           read_json(manifest).value("configuration", Json()) == make_pack_stage(c).configuration;
}

double expected_porosity(const Case& c) {
    if (has_packing(c)) return c.result<results::Pack>().bed.porosity_bed;
    return c.from_surface() || c.from_image() ? 0.6 : 1.0 - poured_solid_fraction(case_shapes(c), case_container(c));
}

// The section before the packing exists: the height at which pouring stops, minus one grain at both ends.
PoreSpace expected_pore_space(const Case& c) {
    const auto& settings = c.settings;
    if (has_packing(c)) {
        Case without_menisci = c;  // they take a minute, and change little of memory and time
        without_menisci.settings.geometry.closing_radius_m = 0.0;
        return case_pore_space(without_menisci);
    }
    if (c.from_image())  // read again where the stage has not run: an image takes seconds
        return load_pore_space(c.resolve(c.settings.image.file), {.container = container_of_image(c),
                                                                  .geometry = c.settings.geometry,
                                                                  .section = c.settings.section,
                                                                  .image = c.settings.image});
    PoreSpace space{.container = case_container(c), .section = {}};
    double top = c.from_fit() ? space.container.height() : space.container.height() / 2.0;
    if (!c.from_surface()) {
        const std::vector<ShapeShare> shapes = case_shapes(c);
        for (const auto& [shape, share] : shapes) {
            space.maximum_feret_diameter_m = std::max(space.maximum_feret_diameter_m, maximum_feret_diameter(shape));
            space.grain_size_m = std::min(space.grain_size_m, smallest_diameter(shape));
        }
        space.equivalent_diameter_m = std::cbrt(6.0 * mean_volume_m3(shapes) / std::numbers::pi);
        if (settings.packing.fill_height_m > 0.0) top = settings.packing.fill_height_m;
        if (settings.packing.grains > 0)
            top = std::min(space.container.height(), poured_height_m(shapes, space.container, settings.packing.grains));
    } else {
        space.grain_size_m = grain_size_of(converters::read_surface(c.resolve(settings.shape.file), surface_unit_m(settings.shape)));
    }
    space.section =
        choose_section(space.container, {.section_m = settings.geometry.section_m, .trim_m = settings.geometry.trim_m, .bed_known = false},
                       {0.0, top}, space.maximum_feret_diameter_m);
    space.reservoir_m = settings.geometry.reservoir_m;
    space.bed_top_m = top;
    return space.with_ends(settings.section.ends, settings.section.buffer_m);
}

}  // namespace porepack::stages
