// OpenFOAM alone on flows whose permeability is known: error on three meshes, observed order, extrapolated value.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "openfoam/foam.hpp"
#include "pore_space/pore_space.hpp"
#include "stages/stages.hpp"
#include "support/known_flows.hpp"

namespace porepack::benchmarks {
using namespace test;

FoamScene foam_scene_of(const Packing& packing, const Section& section, double grain_size_m, double deviation) {
    const PoreSpace space = pore_space_of(packing).with_section(section);
    return foam_scene(space, {.deviation_m = deviation * grain_size_m}, grain_size_m / 6.0);
}

Json foam_benchmark(const Path& output) {
    const Path folder = (output.empty() ? Path("foam_verification") : output) / "openfoam";
    make_folder(folder);
    struct Known {
        std::string name;
        FoamScene scene;
        double permeability_m2, cell_size_m;
    };
    std::vector<Known> list;
    // The case needs a surface: a sphere far above an empty duct.
    const auto add_empty = [&](const char* name, const char* container, double area, double k, double cell) {
        Packing packing{.container = parse_container(container), .shapes = {make_preset(ShapeKind::sphere, 0.002, 0.0)}, .bodies = {}};
        packing.bodies.push_back({.shape = 0, .position_m = 0.5 * (packing.container.low() + packing.container.high()) + Vec3(0, 0, 0.03)});
        FoamScene scene{.surface = make_surface(packing, {}).surface,
                        .container = packing.container,
                        .section = {0.01, 0.02},
                        .pore_volume_m3 = 0.01 * area,
                        .grain_size_m = 0.01};
        scene.pore_point = Vec3(0.5 * (packing.container.low().x() + packing.container.high().x()) + 1.3e-4,
                                0.5 * (packing.container.low().y() + packing.container.high().y()) + 1.7e-4, 0.01503);
        list.push_back({name, scene, k, cell});
    };
    add_empty("square duct", "box:0.01,0.01,0.1", 1e-4, 0.03514425e-4, 0.01 / 32);
    add_empty("pipe", "cylinder:0.01,0.1", std::numbers::pi * 0.25e-4, 1e-4 / 32.0, 0.01 / 28);
    const auto add = [&](const KnownFlow& known, double cells_per_diameter) {
        list.push_back({known.name, foam_scene_of(known.packing, {0.0, known.container.size().z()}, known.diameter_m),
                        known.permeability_m2, known.diameter_m / cells_per_diameter});
    };
    const Vec3 place(0.21, 0.37, 0.11);
    add(sphere_array(0.125, 4.291589, simple_cubic(), place), 24);
    add(sphere_array(0.343, 15.39949, simple_cubic(), place), 32);
    add(sphere_array(0.343, 16.33505, body_centred(), place), 28);
    add(sphere_array(0.6, 88.8734, body_centred(), place), 40);
    // Square array of cylinders of solid fraction 0.5 across the flow (Drummond & Tahir 1984), along x; the flow goes along z.
    const double radius = std::sqrt(0.5 / std::numbers::pi);
    Packing cylinders{
        .container = parse_container("box:0.25,1,1:periodic"), .shapes = {make_preset(ShapeKind::sphere, 2.0 * radius, 0.0)}, .bodies = {}};
    // The facets of a capsule keep its total volume, but the ends are hidden here: the facets must be fine.
    cylinders.shapes[0].capsules = {{Vec3(-0.25, 0, 0), Vec3(0.25, 0, 0), radius}};
    cylinders.bodies.push_back({.shape = 0, .position_m = Vec3(0.125, 0.5, 0.5)});
    list.push_back({"square cylinders 0.5", foam_scene_of(cylinders, {0.0, 1.0}, 2.0 * radius, 2e-4), 1.0 / 532.548, 1.0 / 40});
    Json rows = Json::array();
    int number = 0;
    for (const Known& known : list) {
        const Stopwatch watch;
        try {
            const FoamResult result = foam_permeability(known.scene, {.meshes = 3, .mesh_ratio = 1.4}, known.cell_size_m,
                                                        data_file("openfoam_cases"), folder / std::to_string(++number));
            Json meshes = Json::array();
            for (const FoamMeshResult& mesh : result.meshes)
                meshes.push_back({{"cells", mesh.cells},
                                  {"error", mesh.permeability_m2 / known.permeability_m2 - 1.0},
                                  {"iterations", mesh.iterations},
                                  {"mesh_volume_ratio", mesh.mesh_volume_ratio}});
            const FoamExtrapolation& found = *result.extrapolation;
            rows.push_back({{"case", known.name},
                            {"meshes", meshes},
                            {"observed_order", found.observed_order ? Json(*found.observed_order) : Json(nullptr)},
                            {"extrapolated_error", found.value / known.permeability_m2 - 1.0},
                            {"half_width", 0.5 * (found.interval.high - found.interval.low) / known.permeability_m2},
                            {"covered", found.interval.low <= known.permeability_m2 && known.permeability_m2 <= found.interval.high},
                            {"seconds", watch.seconds()}});
            log_info("{}: extrapolated {:+.2f} %", known.name, 100.0 * (found.value / known.permeability_m2 - 1.0));
        } catch (const Error& error) {
            log_warning(fmt::format("{}: {}", known.name, error.what()));
        }
    }
    return {{"rows", rows}};
}

}  // namespace porepack::benchmarks
