// Grains in a container: poured, or given.
#include <fmt/format.h>

#include <algorithm>

#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "imaging/volume.hpp"
#include "pore_space/pore_space.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "pouring/liggghts/liggghts.hpp"
#include "record/digest.hpp"
#include "stages/fit.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace record;
using namespace shapes;
using namespace packing;
using namespace pouring;
using namespace pouring::dem;
using namespace pouring::liggghts;
using namespace pore_space;
using namespace imaging;
using namespace pipeline;
namespace {

// Cost and errors of the clump of spheres; LIGGGHTS is still given the exact mass and inertia.
Json clump_json(const Shape& shape, double surface_tolerance) {
    const double tolerance = surface_tolerance * smallest_diameter(shape);
    Shape clump{.id = shape.id, .capsules = sphere_clump(shape, tolerance), .cavity = shape.cavity};
    const ShapeMeasures exact = measure(shape, 1e-6), of_clump = measure(clump, 1e-6);
    return {
        {"shape", shape.id},
        {"spheres", clump.capsules.size()},
        {"largest_surface_error_m", tolerance},
        {"volume_error", of_clump.volume_m3 / (exact.volume_m3 - (shape.cavity == Cavity::filled ? exact.cavity_volume_m3 : 0.0)) - 1.0},
        {"area_error", of_clump.surface_area_m2 / exact.surface_area_m2 - 1.0}};
}

// Carman-Kozeny, Ergun and the report use the shape of the case: it must be that of the packing.
void require_same_shape(const std::vector<ShapeShare>& shapes, const Packing& packing, const std::string& file) {
    for (const auto& other : packing.shapes) {
        const double volume = measure(other, 1e-6).volume_m3;
        if (std::none_of(shapes.begin(), shapes.end(),
                         [&](const ShapeShare& share) { return std::abs(volume / measure(share.shape, 1e-6).volume_m3 - 1.0) < 1e-3; }))
            throw UserError(fmt::format("the grain of the case is not the one of the packing: {:.4g} m3, `{}` has {:.4g} m3",
                                        measure(shapes.front().shape, 1e-6).volume_m3, other.id, volume),
                            {.where = file, .fix = "let [shape] describe the packing's grain"});
    }
}

// A packing given by the user, which must be the one that the case describes.
Packing given_packing(const Case& c, const Container& container, const std::vector<ShapeShare>& shapes) {
    const std::string& file = c.settings.packing.file;
    if (file.empty()) throw UserError("engine = \"none\" needs a packing", {.where = "[packing]", .fix = "file = \"packing.json\""});
    Packing packing = read_packing(c.resolve(file));
    if (to_json(packing.container) != to_json(container))
        throw UserError(
            "the container of the packing is not the one of the case",
            {.where = file, .allowed = to_json(container).dump(), .fix = "[container] must say " + to_json(packing.container).dump()});
    require_same_shape(shapes, packing, file);
    return packing;
}

void add_pour(Json& json, const PourResult& pour, const std::vector<ShapeShare>& shapes, const PackingConfig& config) {
    const double d = finest_diameter(pour.packing);
    json["batches"] = pour.batches;
    json["thinned_batches"] = pour.thinned_batches;
    json["steps"] = pour.steps;
    json["kinetic_energy_per_grain_J"] = pour.kinetic_energy_per_grain_J;
    json["rest_limit_J"] = pour.rest_limit_J;
    json["at_rest"] = pour.at_rest();
    if (pour.coordination_number) json["coordination_number"] = *pour.coordination_number;
    if (pour.mean_force_over_weight) json["mean_force_over_weight"] = *pour.mean_force_over_weight;
    if (pour.largest_force_over_weight) json["largest_force_over_weight"] = *pour.largest_force_over_weight;
    if (config.engine == Engine::liggghts) {
        json["pose_error_relative_to_diameter"] = *pour.pose_error_m / d;
        json["largest_clump_overlap_relative_to_diameter"] = *pour.largest_clump_overlap_m / d;
        json["clumps"] = Json::array();
        for (const auto& share : shapes) json["clumps"].push_back(clump_json(share.shape, config.surface_tolerance));
        json["repeat_by_hand"] = "cd run && " + pour.command;
    }
    json["engine_wall_time_s"] = pour.wall_time_s;
}

void add_grains(Json& json, const Packing& packing) {
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing);
    json["grains"] = packing.bodies.size();
    if (packing.shapes.size() > 1) {
        std::vector<long> count(packing.shapes.size(), 0);
        for (const auto& body : packing.bodies) ++count[body.shape];
        for (std::size_t i = 0; i < count.size(); ++i) json["grains_of_shape"][packing.shapes[i].id] = count[i];
    }
    json["largest_overlap_relative_to_diameter"] = overlaps.largest_between_grains_m / d;
    json["mean_overlap_relative_to_diameter"] = overlaps.mean_between_grains_m / d;
    json["largest_wall_overlap_relative_to_diameter"] = overlaps.largest_with_wall_m / d;
    json["contacts"] = overlaps.contacts;
}

// The spheres of LIGGGHTS's clumps lie within surface_tolerance of the grains, so the exact grains may overlap by more than soft contacts.
void allow_clump_overlaps(Packing& packing, const PackingConfig& config) {
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing), largest = std::max(overlaps.largest_between_grains_m, overlaps.largest_with_wall_m);
    packing.overlap_allowed = largest > largest_overlap_of_diameter * d && largest <= config.surface_tolerance * d;
    if (packing.overlap_allowed)
        log_warning(fmt::format("grains overlap by up to {:.2g} of the thinnest capsule's diameter: surface_tolerance is {:g}", largest / d,
                                config.surface_tolerance));
}

// Grains found in the scan.
Json run_fit(const Case& c, const Path& folder) {
    std::vector<Shape> shapes;
    for (const ShapeShare& share : make_shapes(c.settings.shape)) shapes.push_back(share.shape);
    Json json = {{"engine", "fit"}};
    json["fit"] = fit_image(c.resolve(c.settings.image.file), c.settings.image, container_of_image(c), shapes, folder);
    const Packing packing = read_packing(folder / "packing.json");
    add_grains(json, packing);
    add_bed_porosity(json, pore_space_of(packing));
    return json;
}

Json run_pack(const Case& c, const Path& folder) {
    const PackingConfig& config = c.settings.packing;
    const Container container = make_container(c.settings.container);
    const std::vector<ShapeShare> shapes = make_shapes(c.settings.shape);
    Json json = {{"engine", name_of(config.engine)}, {"seed", config.seed}};
    Packing packing;
    if (config.engine == Engine::none) {
        packing = given_packing(c, container, shapes);
    } else {
        const PourResult pour = config.engine == Engine::liggghts
                                    ? pour_with_liggghts(shapes, container, config, data_file("liggghts_templates"), folder / "run")
                                    : pour_with_capsules(shapes, container, config, folder);
        packing = pour.packing;
        add_pour(json, pour, shapes, config);
    }
    if (config.engine == Engine::liggghts) allow_clump_overlaps(packing, config);
    add_grains(json, packing);
    if (packing.overlap_allowed) json["overlap_allowed"] = true;
    write_packing(folder / "packing.json", packing);
    add_bed_porosity(json, pore_space_of(read_packing(folder / "packing.json")));
    return json;
}

// From measurements (docs/images.md).
Expectation expect_fit(double voxels) {
    return {.text = fmt::format("grains in {:.2g} voxels", voxels), .memory_bytes = 15.0 * voxels, .wall_time_s = 6e-6 * voxels};
}

Expectation expect_pack(const Case& c) {
    const PackingConfig& config = c.settings.packing;
    if (c.from_fit())
        return expect_fit(static_cast<double>(open_volume(c.resolve(c.settings.image.file), c.settings.image).header.count()));
    if (config.engine == Engine::none) return {.text = "seconds"};
    const PourPlan plan = plan_pour(make_shapes(c.settings.shape), make_container(c.settings.container), config);
    const std::string engine = config.engine == Engine::liggghts
                                   ? fmt::format("LIGGGHTS, up to {} grains of {} spheres", plan.maximum_grains, plan.clump_spheres)
                                   : fmt::format("capsules, up to {} grains", plan.maximum_grains);
    std::string text = fmt::format("{}, time step {:.2e} s", engine, plan.time_step_s);
    if (!c.settings.geometry.section_m.empty())
        if (const PoreSpace bed = expected_pore_space(c); bed.section.z1 > bed.bed_top_m)
            text += fmt::format("; the section ends at {:g} m, above the expected top of the bed (about {:.2g} m)", bed.section.z1,
                                bed.bed_top_m);
    return {.text = text, .memory_bytes = plan.expected_memory_bytes, .wall_time_s = plan.expected_wall_time_s};
}

}  // namespace

void add_bed_porosity(Json& json, const PoreSpace& bed) {
    const Porosity porosity = bed.porosity();
    json["bed_height_m"] = bed.section.z1;
    json["porosity_bed"] = porosity.value;
    json["porosity_bed_uncertainty"] = porosity.uncertainty;
}

Stage make_pack_stage(const Case& c) {
    if (c.from_fit())
        return {.name = "pack",
                .configuration = c.settings.resolved_tables({"shape", "image", "container"}),
                .files = open_volume(c.resolve(c.settings.image.file), c.settings.image).header.files,
                .outputs = {"packing.json"},
                .run = [c](const Path& folder) { return run_fit(c, folder); },
                .expect = [c] { return expect_pack(c); }};
    const PackingConfig& config = c.settings.packing;
    Json configuration = c.settings.resolved_tables({"shape", "container", "packing"});
    configuration["packing"].erase("friction_uncertainty");  // it decides other packings, not this one
    Stage stage{.name = "pack",
                .configuration = configuration,
                .outputs = {"packing.json"},
                .run = [c](const Path& folder) { return run_pack(c, folder); },
                .expect = [c] { return expect_pack(c); },
                .resumes = config.engine != Engine::none,
                .processes = config.processes};
    if (config.engine == Engine::none && !config.file.empty()) stage.files = {c.resolve(config.file)};
    for (const Path& file : stage.files) (void)sha256_of_file(file);  // a missing file is named before anything runs
    return stage;
}

}  // namespace porepack::stages
