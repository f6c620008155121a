#include "apps/scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack {
namespace {

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

}  // namespace porepack
