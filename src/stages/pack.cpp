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
#include "stages/stages.hpp"
#include "core/json.hpp"

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
results::Clump clump_of(const Shape& shape, double surface_tolerance) {
    const double tolerance = surface_tolerance * smallest_diameter(shape);
    Shape clump{.id = shape.id, .capsules = sphere_clump(shape, tolerance), .cavity = shape.cavity};
    const ShapeMeasures exact = measure(shape, 1e-6), of_clump = measure(clump, 1e-6);
    const double solid = exact.volume_m3 - (shape.cavity == Cavity::filled ? exact.cavity_volume_m3 : 0.0);
    return {.shape = shape.id,
            .spheres = clump.capsules.size(),
            .largest_surface_error_m = tolerance,
            .volume_error = of_clump.volume_m3 / solid - 1.0,
            .area_error = of_clump.surface_area_m2 / exact.surface_area_m2 - 1.0};
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

results::Pour result_of(const PourResult& pour, const std::vector<ShapeShare>& shapes, const PackingConfig& config) {
    results::Pour result{.batches = pour.batches,
                         .thinned_batches = pour.thinned_batches,
                         .steps = pour.steps,
                         .kinetic_energy_per_grain_J = pour.kinetic_energy_per_grain_J,
                         .rest_limit_J = pour.rest_limit_J,
                         .at_rest = pour.at_rest(),
                         .coordination_number = pour.coordination_number,
                         .mean_force_over_weight = pour.mean_force_over_weight,
                         .largest_force_over_weight = pour.largest_force_over_weight,
                         .engine_wall_time_s = pour.wall_time_s};
    if (config.engine == Engine::liggghts) {
        const double d = finest_diameter(pour.packing);
        result.pose_error_relative_to_diameter = *pour.pose_error_m / d;
        result.largest_clump_overlap_relative_to_diameter = *pour.largest_clump_overlap_m / d;
        result.clumps.emplace();
        for (const auto& share : shapes) result.clumps->push_back(clump_of(share.shape, config.surface_tolerance));
        result.repeat_by_hand = "cd run && " + pour.command;
    }
    return result;
}

void add_grains(results::Pack& pack, const Packing& packing) {
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing);
    pack.grains = packing.bodies.size();
    if (packing.shapes.size() > 1) {
        std::vector<long> count(packing.shapes.size(), 0);
        for (const auto& body : packing.bodies) ++count[body.shape];
        pack.grains_of_shape.emplace();
        for (std::size_t i = 0; i < count.size(); ++i) pack.grains_of_shape->emplace_back(packing.shapes[i].id, count[i]);
    }
    pack.largest_overlap_relative_to_diameter = overlaps.largest_between_grains_m / d;
    pack.mean_overlap_relative_to_diameter = overlaps.mean_between_grains_m / d;
    pack.largest_wall_overlap_relative_to_diameter = overlaps.largest_with_wall_m / d;
    pack.contacts = overlaps.contacts;
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
results::Pack run_fit(const Case& c, const Path& folder) {
    std::vector<Shape> shapes;
    for (const ShapeShare& share : make_shapes(c.settings.shape)) shapes.push_back(share.shape);
    results::Pack result{.engine = "fit"};
    result.fit = fit_image(c.resolve(c.settings.image.file), c.settings.image, container_of_image(c), shapes, folder);
    const Packing packing = read_packing(folder / "packing.json");
    add_grains(result, packing);
    result.bed = bed_porosity(pore_space_of(packing));
    return result;
}

results::Pack run_pack(const Case& c, const Path& folder) {
    const PackingConfig& config = c.settings.packing;
    const Container container = make_container(c.settings.container);
    const std::vector<ShapeShare> shapes = make_shapes(c.settings.shape);
    results::Pack result{.engine = std::string(name_of(config.engine)), .seed = config.seed};
    Packing packing;
    if (config.engine == Engine::none) {
        packing = given_packing(c, container, shapes);
    } else {
        const PourResult pour = config.engine == Engine::liggghts
                                    ? pour_with_liggghts(shapes, container, config, data_file("liggghts_templates"), folder / "run")
                                    : pour_with_capsules(shapes, container, config, folder);
        packing = pour.packing;
        result.pour = result_of(pour, shapes, config);
    }
    if (config.engine == Engine::liggghts) allow_clump_overlaps(packing, config);
    add_grains(result, packing);
    if (packing.overlap_allowed) result.overlap_allowed = true;
    write_packing(folder / "packing.json", packing);
    result.bed = bed_porosity(pore_space_of(read_packing(folder / "packing.json")));
    return result;
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

results::BedPorosity bed_porosity(const PoreSpace& bed) {
    const Porosity porosity = bed.porosity();
    return {.bed_height_m = bed.section.z1, .porosity_bed = porosity.value, .porosity_bed_uncertainty = porosity.uncertainty};
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
