// The stages from a grain to voxels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/stage_json.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "packing/capsule_pour.hpp"
#include "packing/liggghts.hpp"

namespace porepack {
namespace {

void add_bed_porosity(Json& json, const Scene& bed_scene) {
    const Porosity bed = porosity(bed_scene.solid(), bed_scene.container, bed_scene.section);
    json["bed_height_m"] = bed_scene.section.z1;
    json["porosity_bed"] = bed.value;
    json["porosity_bed_uncertainty"] = bed.uncertainty;
}

Json mixture_json(const ShapeConfig& config, double density);

void add_inertia(Json& json, const Eigen::Matrix3d& inertia) {
    json["inertia_kg_m2"] = Json::array();
    for (int row = 0; row < 3; ++row) json["inertia_kg_m2"].push_back(list(Vec3(inertia.row(row).transpose())));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    json["principal_moments_kg_m2"] = list(Vec3(axes.eigenvalues()));
    json["principal_axes"] = Json::array();
    for (int i = 0; i < 3; ++i) json["principal_axes"].push_back(list(Vec3(axes.eigenvectors().col(i))));
}

}  // namespace

Json shape_stage(const ShapeConfig& config, double density) {
    if (config.kind == "mixture") return mixture_json(config, density);
    const Shape shape = make_shape(config);
    const ShapeMeasures m = measure(shape);
    Json json = {{"kind", config.kind}, {"cavity", shape.cavity == Cavity::filled ? "filled" : "open"}};
    if (config.kind != "capsules") {
        json["diameter_m"] = 2.0 * shape.capsules.front().radius;
        json["length_m"] = (shape.capsules.front().b - shape.capsules.front().a).norm();
    }
    json["capsules"] = shape.capsules.size();
    json["volume_m3"] = m.volume_m3;
    json["surface_area_m2"] = m.surface_area_m2;
    json["sphericity"] = m.sphericity;
    const HullMeasures convex = hull(shape.capsules);
    json["convexity"] = std::min(1.0, m.volume_m3 / convex.volume_m3);
    json["convex_hull_volume_m3"] = convex.volume_m3;
    json["convex_hull_area_m2"] = convex.surface_area_m2;
    json["equal_volume_diameter_m"] = std::cbrt(6.0 * m.volume_m3 / std::numbers::pi);
    json["cavity_volume_m3"] = m.cavity_volume_m3;
    json["cavity_area_m2"] = m.cavity_area_m2;
    if (m.cavity_volume_m3 > 0.0) {
        const bool filled = shape.cavity == Cavity::filled;
        json["volume_filled_m3"] = m.volume_m3 + (filled ? 0.0 : m.cavity_volume_m3);
        json["volume_open_m3"] = m.volume_m3 - (filled ? m.cavity_volume_m3 : 0.0);
        json["surface_area_filled_m2"] = m.surface_area_m2 - (filled ? 0.0 : m.cavity_area_m2);
        json["surface_area_open_m2"] = m.surface_area_m2 + (filled ? m.cavity_area_m2 : 0.0);
    }
    json["centre_of_mass_m"] = list(m.centre_of_mass_m);
    json["density_kg_per_m3"] = density;
    json["mass_kg"] = density * m.volume_m3;
    add_inertia(json, density * m.inertia_per_density_m5);
    json["bounding_radius_m"] = m.bounding_radius_m;
    json["span_m"] = m.span_m;
    json["relative_error"] = m.relative_error;
    return json;
}

namespace {

// The mixture's own numbers are means over the grains, by number; its sphericity is the one that gives the mixture's specific
// surface (6 V/A = sphericity times the equal-volume diameter), as Carman-Kozeny's equation wants it.
Json mixture_json(const ShapeConfig& config, double density) {
    Json json = {{"kind", "mixture"}, {"components", Json::array()}};
    double volume = 0.0, area = 0.0, error = 0.0;
    (void)make_shapes(config);  // its faults are named before anything is measured
    for (const auto& part : config.component) {
        Json component = shape_stage(part, density);
        component["number_fraction"] = part.number_fraction;
        volume += part.number_fraction * component["volume_m3"].get<double>();
        area += part.number_fraction * component["surface_area_m2"].get<double>();
        error = std::max(error, component["relative_error"].get<double>());
        json["components"].push_back(component);
    }
    json["volume_m3"] = volume;
    json["surface_area_m2"] = area;
    json["sphericity"] = std::cbrt(36.0 * std::numbers::pi * volume * volume) / area;
    json["equal_volume_diameter_m"] = std::cbrt(6.0 * volume / std::numbers::pi);
    json["relative_error"] = error;
    return json;
}

}  // namespace

Json surface_shape_stage(const Path& stl, double unit_m, double density) {
    const TriangleSurface surface = read_stl(stl, unit_m);
    const SurfaceCheck check = check_surface(surface);
    require_sound(check, stl.string());
    const SurfaceMeasures m = measure_surface(surface);
    Json json = {{"kind", "stl"},
                 {"shells", check.shells},
                 {"volume_m3", m.volume_m3},
                 {"surface_area_m2", m.area_m2},
                 {"low_m", list(check.low)},
                 {"high_m", list(check.high)},
                 {"convexity", std::min(1.0, m.volume_m3 / m.hull_volume_m3)},
                 {"convex_hull_volume_m3", m.hull_volume_m3},
                 {"convex_hull_area_m2", m.hull_area_m2},
                 {"centre_of_mass_m", list(m.centre_of_mass_m)},
                 {"density_kg_per_m3", density},
                 {"mass_kg", density * m.volume_m3},
                 {"bounding_radius_m", m.bounding_radius_m},
                 {"span_m", m.span_m}};
    add_inertia(json, density * m.inertia_per_density_m5);
    // The correlations want one grain's sphericity, which several bodies together do not have.
    json["sphericity_of_all"] = m.sphericity;
    return json;
}

namespace {

// What the clump of spheres costs, and what it gets wrong: LIGGGHTS is given the exact mass and inertia all the same.
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

// Carman-Kozeny, Ergun and the report speak of the case's shape: it must be the packing's.
void require_same_shape(const std::vector<ShapeShare>& shapes, const Packing& packing, const std::string& file) {
    for (const auto& other : packing.shapes) {
        const double volume = measure(other, 1e-6).volume_m3;
        if (std::none_of(shapes.begin(), shapes.end(),
                         [&](const ShapeShare& share) { return std::abs(volume / measure(share.shape, 1e-6).volume_m3 - 1.0) < 1e-3; }))
            throw UserError(fmt::format("the grain of the case is not the one of the packing: {:.4g} m3, `{}` has {:.4g} m3",
                                        measure(shapes.front().shape, 1e-6).volume_m3, other.id, volume),
                            {.where = file, .mend = "let [shape] describe the packing's grain"});
    }
}

}  // namespace

Json pack_stage(const Case& the_case, const Path& folder) {
    const auto& config = the_case.settings.packing;
    const Container container = make_container(the_case.settings.container);
    Json json = {{"engine", config.engine}, {"seed", config.seed}};
    Packing packing;
    const std::vector<ShapeShare> shapes = make_shapes(the_case.settings.shape);
    if (config.engine == "none") {
        if (config.file.empty())
            throw UserError("engine = \"none\" needs a packing", {.where = "[packing]", .mend = "file = \"packing.json\""});
        packing = read_packing(the_case.resolve(config.file));
        if (to_json(packing.container) != to_json(container))
            throw UserError("the container of the packing is not the one of the case",
                            {.where = config.file,
                             .allowed = to_json(container).dump(),
                             .mend = "[container] must say " + to_json(packing.container).dump()});
        require_same_shape(shapes, packing, config.file);
    } else {
        const bool liggghts = config.engine == "liggghts";
        const PourResult pour = liggghts
                                    ? pour_with_liggghts(shapes, container, config, home_folder() / "liggghts_templates", folder / "run")
                                    : pour_with_capsules(shapes, container, config, folder);
        packing = pour.packing;
        json["batches"] = pour.batches;
        json["thinned_batches"] = pour.thinned_batches;
        json["steps"] = pour.steps;
        json["kinetic_energy_per_grain_J"] = pour.kinetic_energy_per_grain_J;
        json["rest_limit_J"] = pour.rest_limit_J;
        json["at_rest"] = pour.at_rest();
        if (pour.coordination_number) json["coordination_number"] = *pour.coordination_number;
        if (pour.mean_force_over_weight) json["mean_force_over_weight"] = *pour.mean_force_over_weight;
        if (pour.largest_force_over_weight) json["largest_force_over_weight"] = *pour.largest_force_over_weight;
        if (liggghts) {
            json["pose_error_relative_to_diameter"] = *pour.pose_error_m / finest_diameter(packing);
            json["largest_clump_overlap_relative_to_diameter"] = *pour.largest_clump_overlap_m / finest_diameter(packing);
            json["clumps"] = Json::array();
            for (const auto& share : shapes) json["clumps"].push_back(clump_json(share.shape, config.surface_tolerance));
            json["repeat_by_hand"] = "cd run && " + pour.command;
        }
        json["engine_wall_time_s"] = pour.wall_time_s;
    }
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing);
    json["grains"] = packing.bodies.size();
    if (packing.shapes.size() > 1) {
        json["grains_of_shape"] = Json::object();
        for (const auto& shape : packing.shapes) json["grains_of_shape"][shape.id] = 0;
        for (const auto& body : packing.bodies) {
            Json& count = json["grains_of_shape"][packing.shapes[body.shape].id];
            count = count.get<long>() + 1;
        }
    }
    json["largest_overlap_relative_to_diameter"] = overlaps.largest_between_grains_m / d;
    json["mean_overlap_relative_to_diameter"] = overlaps.mean_between_grains_m / d;
    json["largest_wall_overlap_relative_to_diameter"] = overlaps.largest_with_wall_m / d;
    json["contacts"] = overlaps.contacts;
    write_packing(folder / "packing.json", packing);
    add_bed_porosity(json, load_bed(folder / "packing.json", std::nullopt, 1.0));
    return json;
}

namespace {

// What the table [stl] asks for beside solid.stl.
void write_extra_surfaces(const Scene& scene, const GeometryConfig& geometry, const StlConfig& extras, const TriangleSurface& solid,
                          const Path& folder, Json& json) {
    const double deviation = scene.surface_deviation(geometry);
    const double section_volume = scene.container.inner_area_m2() * scene.section.length();
    if (extras.pores) {
        const PoreSurface pores = make_pore_surface(solid, scene.container, scene.section, deviation);
        write_stl_regions(folder / "pores.stl", pores.surface, pores.region, {"inlet", "outlet", "wall", "grains"});
        const SurfaceMeasures measures = measure_surface(pores.surface);
        json["pores"] = {{"section_m", list(scene.section)},
                         {"volume_m3", measures.volume_m3},
                         {"porosity", measures.volume_m3 / section_volume},
                         {"triangles", pores.surface.triangles.size()}};
    }
    if (extras.clip) {
        const TriangleSurface clipped = clip_surface(solid, scene.section);
        write_stl(folder / "clipped.stl", clipped);
        json["clipped"] = {{"section_m", list(scene.section)}, {"volume_m3", measure_surface(clipped).volume_m3}};
    }
    if (extras.one_file_a_grain) {
        if (!scene.packing) throw UserError("an STL file's grains cannot be told apart", {.mend = "leave one_file_a_grain out"});
        make_folder(folder / "grains");
        Packing one{.container = scene.packing->container, .shapes = scene.packing->shapes, .bodies = {}};
        one.container.periodic = {false, false, false};
        for (std::size_t b = 0; b < scene.packing->bodies.size(); ++b) {
            one.bodies = {scene.packing->bodies[b]};
            write_stl(folder / "grains" / fmt::format("grain_{:05}.stl", b + 1), make_surface(one, {.deviation_m = deviation}).surface);
        }
        json["grain_files"] = scene.packing->bodies.size();
    }
    if (extras.also == "ply" || extras.also == "both") write_ply(folder / "solid.ply", solid);
    if (extras.also == "vtp" || extras.also == "both") write_vtp(folder / "solid.vtp", solid);
    if (extras.millimetres) {
        TriangleSurface scaled = solid;
        for (auto& p : scaled.points)
            for (double& x : p) x *= 1000.0;
        write_stl(folder / "solid_mm.stl", scaled, "porepack; unit: millimetre");
        json["unit_of_solid_mm"] = "millimetre";
    }
}

}  // namespace

Json stl_stage(const Scene& scene, const GeometryConfig& geometry, const StlConfig& extras, const Path& folder) {
    Json json;
    const Path file = folder / "solid.stl";
    if (scene.packing) {
        const SurfaceResult result =
            make_surface(*scene.packing, {.deviation_m = geometry.surface_deviation_m, .contact_gap_m = geometry.contact_gap_m});
        write_stl(file, result.surface);
        const Porosity exact = porosity(*scene.grains, scene.container, {0.0, scene.container.height()});
        const double solid = (1.0 - exact.value) * scene.container.inner_area_m2() * scene.container.height();
        json["largest_deviation_m"] = result.deviation_m;
        json["contact_gap_m"] = result.contact_gap_m;
        json["joined_grains"] = result.joined_grains;
        json["contacts_joined"] = result.bridges;
        json["thinned_grains"] = result.shrunk_grains;
        if (!scene.container.any_periodic()) json["exact_volume_m3"] = solid;
    } else {
        write_stl(file, *scene.surface);
    }
    // What is claimed is checked on the file as it was written, in single precision.
    const TriangleSurface written = read_stl(file);
    const SurfaceCheck check = check_surface(written);
    if (!check.fault.empty())
        throw NumericalError("the surface written is not sound: " + check.fault,
                             {.where = file.string(), .mend = "change surface_deviation_m or contact_gap_m"});
    json["triangles"] = (std::filesystem::file_size(file) - 84) / 50;
    json["shells"] = check.shells;
    json["closed"] = check.closed;
    json["outward"] = check.outward;
    json["self_intersecting"] = check.self_intersecting;
    json["volume_m3"] = check.volume_m3;
    json["area_m2"] = check.area_m2;
    if (json.contains("exact_volume_m3")) {
        const double exact = json["exact_volume_m3"].get<double>();
        json["volume_error"] = check.volume_m3 / exact - 1.0;
        // Facets and bridges together, over the bed.
        json["porosity_change"] =
            (exact - check.volume_m3) / (scene.container.inner_area_m2() * std::min(scene.bed_top_m, scene.container.height()));
    }
    write_extra_surfaces(scene, geometry, extras, written, folder, json);
    if (!scene.packing) add_bed_porosity(json, scene);
    return json;
}

Json voxelise_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder) {
    const VoxelPlan plan =
        plan_voxels(scene.container, scene.section, scene.voxel_size(geometry), geometry.reservoir_m, scene.grain_size_m);
    const PhaseImage image = voxelise(scene.solid(), scene.container, scene.section, plan);
    write_phase_image(folder / "pore.vti", image);
    std::array<double, 3> count = {0, 0, 0};
    for (const auto phase : image.phase) count[phase] += 1.0;
    const Porosity exact = porosity(scene.solid(), scene.container, scene.section);
    return {{"voxel_size_m", plan.voxel_size_m},
            {"cells", plan.grid.cells},
            {"section_m", list(scene.section)},
            {"reservoir_cells", plan.reservoir_cells},
            {"porosity_of_voxels", count[pore] / (count[pore] + count[grain])},
            {"porosity", exact.value},
            {"porosity_uncertainty", exact.uncertainty},
            {"expected_memory_bytes", plan.memory_bytes}};
}

Json slices_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder) {
    const int count = write_slices(folder, scene.solid(), scene.container, scene.section, geometry.slice_spacing_m, geometry.slice_pixel_m);
    return {{"slices", count},
            {"spacing_m", geometry.slice_spacing_m},
            {"pixel_m", geometry.slice_pixel_m},
            {"section_m", list(scene.section)}};
}

}  // namespace porepack
