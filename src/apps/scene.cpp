#include "apps/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack {
namespace {

Container container_of_note(const std::string& note, const Path& file) {
    const Json json = Json::parse(note, nullptr, false);
    if (json.is_discarded())
        throw UserError("the image's field data `container` is not JSON: " + note,
                        {.where = file.string(), .mend = "--container cylinder:D,H or box:X,Y,Z[:periodic] (metres)"});
    return container_from_json(json, file.string());
}

// The image covers the container's cross section, to a voxel or two.
void require_same_size(const Grid& grid, const Container& container, const Path& file) {
    const Vec3 inner = container.high() - container.low();
    for (const int axis : {0, 1}) {
        const auto a = static_cast<std::size_t>(axis);
        const double width = grid.cells[a] * grid.spacing_m[a];
        if (std::abs(width - inner[axis]) > 2.01 * grid.spacing_m[a])
            throw UserError(fmt::format("the image is {:g} m wide along axis {}, the container {:g} m", width, axis, inner[axis]),
                            {.where = file.string(), .mend = "give the container that the image shows (--container, metres)"});
    }
}

bool is_packing(const Path& input) {
    const std::string name = input.filename().string();
    return name.ends_with(".json") || name.ends_with(".json.gz");
}

void load_packing(Scene& scene, const Path& input) {
    scene.packing = read_packing(input);
    if (scene.packing->bodies.empty()) throw UserError("the packing has no grain: " + input.string());
    scene.container = scene.packing->container;
    scene.grains = std::make_unique<Grains>(*scene.packing);
    scene.grain_size_m = finest_diameter(*scene.packing);
    for (const auto& shape : scene.packing->shapes) scene.grain_span_m = std::max(scene.grain_span_m, span(shape));
    scene.bed_top_m = scene.grains->bounds().high.z();
}

void load_surface(Scene& scene, const Path& input, const std::optional<Container>& container, double unit_m) {
    if (!container)
        throw UserError("an STL file needs a container",
                        {.where = input.string(), .allowed = "--container cylinder:D,H or box:X,Y,Z[:periodic] (metres)"});
    scene.surface = read_stl(input, unit_m);
    scene.container = *container;
    const SurfaceCheck check = check_surface(*scene.surface);
    require_plausible_size(check, *container, input.string());
    require_sound(check, input.string());
    scene.surface_solid = std::make_unique<SurfaceSolid>(*scene.surface, *container);
    scene.grain_size_m = 4.0 * check.volume_m3 / check.area_m2;  // the diameter of a long capsule
    scene.bed_top_m = check.high.z();
    // What hangs together in an STL may be one grain or the whole bed: a quarter of the bed at most is trimmed.
    scene.grain_span_m = std::min(check.largest_shell_span_m, 0.25 * scene.bed_top_m);
}

}  // namespace

GrainMeans grain_means(const Packing& packing) {
    std::vector<ShapeMeasures> measures;
    for (const Shape& shape : packing.shapes) measures.push_back(measure(shape, 1e-6));
    double volume = 0.0, area = 0.0;
    for (const Body& body : packing.bodies) {
        volume += measures[body.shape].volume_m3;
        area += measures[body.shape].surface_area_m2;
    }
    return {std::cbrt(6.0 * volume / static_cast<double>(packing.bodies.size()) / std::numbers::pi), 6.0 * volume / area};
}

double Scene::voxel_size(const GeometryConfig& geometry) const {
    if (geometry.voxel_size_m > 0.0) return geometry.voxel_size_m;
    if (grains) return grain_size_m / 10.0;
    throw UserError("the voxel size is missing: an STL file does not tell how thick its grains are",
                    {.mend = "--voxel-size (metres), or voxel_size_m in [geometry]"});
}

Scene load_bed(const Path& input, const std::optional<Container>& container, double unit_m) {
    Scene scene;
    if (!(unit_m >= 1e-12 && unit_m <= 1e6))
        throw UserError(fmt::format("a unit of {:g} m is not possible", unit_m), {.allowed = "1e-12 to 1e6 (0.001: millimetres)"});
    if (is_packing(input))
        load_packing(scene, input);
    else if (input.extension() == ".stl" || input.extension() == ".STL")
        load_surface(scene, input, container, unit_m);
    else
        throw UserError("cannot tell what " + input.string() + " is",
                        {.allowed = "packing.json, packing.json.gz, an .stl file, or a case"});
    scene.section = {0.0, scene.container.any_periodic() ? scene.container.height() : std::min(scene.bed_top_m, scene.container.height())};
    return scene;
}

Scene load_scene(const Path& input, const std::optional<Container>& container, const GeometryConfig& geometry, double unit_m) {
    Scene scene = load_bed(input, container, unit_m);
    scene.section =
        choose_section(scene.container, {.section_m = geometry.section_m, .trim_m = geometry.trim_m}, scene.bed_top_m, scene.grain_span_m);
    if (scene.section.length() < scene.grain_span_m && !scene.container.any_periodic())
        log_warning(fmt::format("the section is {:.3g} m long, less than one grain's span ({:.3g} m): it hardly stands for the packing",
                                scene.section.length(), scene.grain_span_m));
    return scene;
}

Section section_of_note(const std::string& note, const Path& file) {
    Section section;
    if (std::sscanf(note.c_str(), "%lf,%lf", &section.z0, &section.z1) != 2 || !std::isfinite(section.z0) || !std::isfinite(section.z1))
        throw UserError("the image's field data `section` is not \"z0,z1\": " + note,
                        {.where = file.string(), .mend = "--section z0,z1 (metres)"});
    return section;
}

ImageScene load_image(const Path& pore_vti, const std::optional<Container>& container, const std::vector<double>& section_m) {
    ImageScene scene{.image = read_phase_image(pore_vti), .container = {}, .section = {}};
    const auto& grid = scene.image.grid;
    const auto& notes = scene.image.notes;
    if (container)
        scene.container = *container;
    else if (notes.contains("container"))
        scene.container = container_of_note(notes.at("container"), pore_vti);
    else
        throw UserError("the image does not say what its container is",
                        {.where = pore_vti.string(), .mend = "--container cylinder:D,H or box:X,Y,Z[:periodic] (metres)"});
    require_same_size(grid, scene.container, pore_vti);
    const Section whole{grid.origin_m[2], grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2]};
    scene.section = whole;
    if (section_m.size() == 2)
        scene.section = {section_m[0], section_m[1]};
    else if (notes.contains("section"))
        scene.section = section_of_note(notes.at("section"), pore_vti);
    const double slack = 0.5 * grid.spacing_m[2];
    if (scene.section.z0 < whole.z0 - slack || scene.section.z1 > whole.z1 + slack || scene.section.length() < grid.spacing_m[2])
        throw UserError(fmt::format("the section from {:g} to {:g} m is not in the image", scene.section.z0, scene.section.z1),
                        {.where = pore_vti.string(), .allowed = fmt::format("{:g} <= z0 < z1 <= {:g} m", whole.z0, whole.z1)});
    return scene;
}

}  // namespace porepack
