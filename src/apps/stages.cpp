#include "apps/stages.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "lbm/permeability.hpp"
#include "openfoam/foam.hpp"
#include "packing/liggghts.hpp"
#include "permeability/permeability.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack {
namespace {

Json list(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

Json list(const Section& section) {
    return {section.z0, section.z1};
}

Json list(const std::optional<Interval>& interval) {
    if (!interval) return nullptr;
    return {interval->low, interval->high};
}

// The section as an image's field data tells it.
Section section_of_note(const std::string& note, const Path& file) {
    Section section;
    if (std::sscanf(note.c_str(), "%lf,%lf", &section.z0, &section.z1) != 2 || !std::isfinite(section.z0) || !std::isfinite(section.z1))
        throw UserError("the image's field data `section` is not \"z0,z1\": " + note,
                        {.where = file.string(), .mend = "--section z0,z1 (metres)"});
    return section;
}

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

void add_bed_porosity(Json& json, const Scene& bed_scene) {
    const Porosity bed = porosity(bed_scene.solid(), bed_scene.container, bed_scene.section);
    json["bed_height_m"] = bed_scene.section.z1;
    json["porosity_bed"] = bed.value;
    json["porosity_bed_uncertainty"] = bed.uncertainty;
}

// k in the units that people use.
void add_permeability(Json& json, double permeability_m2, const std::optional<Interval>& interval) {
    json["permeability_m2"] = permeability_m2;
    json["permeability_interval_m2"] = list(interval);
    json["permeability_darcy"] = permeability_m2 / darcy_m2;
    json["conductivity_m_per_s"] = conductivity_m_per_s(permeability_m2);
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

Path home_folder() {
    const char* home = std::getenv("POREPACK_HOME");
    const Path folder = home != nullptr ? Path(home) : Path(POREPACK_SOURCE_FOLDER);
    if (!std::filesystem::exists(folder / "liggghts_templates"))
        throw UserError("the folder liggghts_templates/ is not in " + folder.string(),
                        {.mend = "set POREPACK_HOME to the project's folder"});
    return folder;
}

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

double finest_diameter(const Packing& packing) {
    double least = 1e300;
    for (const auto& shape : packing.shapes) least = std::min(least, smallest_diameter(shape));
    return least;
}

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
        const PourResult pour = pour_with_liggghts(shapes, container, config, home_folder() / "liggghts_templates", folder / "run");
        packing = pour.packing;
        json["batches"] = pour.batches;
        json["steps"] = pour.steps;
        json["kinetic_energy_per_grain_J"] = pour.kinetic_energy_per_grain_J;
        json["rest_limit_J"] = pour.rest_limit_J;
        json["at_rest"] = true;
        json["pose_error_relative_to_diameter"] = pour.pose_error_m / finest_diameter(packing);
        json["clumps"] = Json::array();
        for (const auto& share : shapes) json["clumps"].push_back(clump_json(share.shape, config.surface_tolerance));
        json["repeat_by_hand"] = "cd run && " + pour.command;
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

namespace {

void write_history(const Path& file, const LbmGridResult& grid) {
    std::string text = "step,permeability_m2,iteration_error,flow_imbalance\n";
    const double h2 = grid.voxel_size_m * grid.voxel_size_m;
    for (const auto& point : grid.run.history)
        text +=
            fmt::format("{},{:.12g},{:.6g},{:.6g}\n", point.step, point.permeability_lu * h2, point.iteration_error, point.flow_imbalance);
    write_text(file, text);
}

Json grid_json(const LbmGridResult& grid) {
    return {{"voxel_size_m", grid.voxel_size_m},
            {"cells", grid.cells},
            {"fluid_nodes", grid.nodes},
            {"isolated_cells", grid.isolated_cells},
            {"permeability_m2", grid.permeability_m2},
            {"steps", grid.run.steps},
            {"seconds", grid.run.seconds},
            {"updates_per_second", grid.run.updates_per_second},
            {"bytes_per_node", grid.bytes_per_node}};
}

Json lbm_json(const LbmResult& result, const Section& section, const LbmConfig& config, const Path& folder) {
    Json json;
    add_permeability(json, result.fine.permeability_m2, result.interval_m2);
    json["permeability_by_volume_average_m2"] = result.fine.permeability_volume_m2;
    json["method"] = "D3Q19 two relaxation times, linear equilibrium, half-way bounce-back";
    json["interval_meaning"] =
        result.interval_m2 ? "first-order Richardson estimate from two grids, at least the 4 % by which bounce-back on voxels scatters"
                           : "one grid: no uncertainty";
    json["direction"] = config.direction;
    json["driven_by"] = result.fine.by_pressure ? "pressure planes" : "body force";
    json["section_m"] = list(section);
    json["converged"] = result.fine.run.converged;
    json["iteration_error"] = result.fine.run.iteration_error;
    json["flow_imbalance"] = result.fine.run.flow_imbalance;
    json["hydraulic_tortuosity"] = result.fine.run.hydraulic_tortuosity;
    json["steps"] = result.fine.run.steps;
    json["updates_per_second"] = result.fine.run.updates_per_second;
    json["relaxation_time"] = config.relaxation_time;
    json["magic_number"] = config.magic_number;
    json["permeability_lu"] = result.fine.run.permeability_lu;
    json["superficial_velocity_lu"] = result.fine.run.superficial_velocity_lu;
    json["fine"] = grid_json(result.fine);
    json["coarse"] = result.coarse ? grid_json(*result.coarse) : Json(nullptr);
    json["peak_memory_bytes"] = peak_memory_bytes();
    write_history(folder / "history.csv", result.fine);
    write_flow_image(folder / "flow.vti", result.flow);
    return json;
}

}  // namespace

Json lbm_stage(const Scene& scene, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder) {
    const auto voxels = [&](double size) {
        return plan_voxels(scene.container, scene.section, size, geometry.reservoir_m, scene.grain_size_m);
    };
    const VoxelPlan plan = voxels(scene.voxel_size(geometry));
    const Porosity pores = porosity(scene.solid(), scene.container, scene.section, 4000);
    const Expectation expected =
        expect_lbm(scene.container, scene.section, plan.voxel_size_m, scene.grain_size_m, pores.value, geometry, config);
    require_memory(expected.memory_bytes,
                   fmt::format("the flow on {} x {} x {} voxels", plan.grid.cells[0], plan.grid.cells[1], plan.grid.cells[2]),
                   "take a larger voxel size or a shorter section");
    const LbmResult result =
        lbm_permeability([&](double size) { return voxelise(scene.solid(), scene.container, scene.section, voxels(size)); },
                         plan.voxel_size_m, scene.container, scene.section, config, true);
    Json json = lbm_json(result, scene.section, config, folder);
    json["expected_memory_bytes"] = expected.memory_bytes;
    return json;
}

Json lbm_image_stage(const Path& pore_vti, const std::optional<Container>& container, const std::vector<double>& section_m,
                     const LbmConfig& config, const Path& folder) {
    const PhaseImage image = read_phase_image(pore_vti);
    const auto& grid = image.grid;
    for (const double spacing : grid.spacing_m)
        if (std::abs(spacing / grid.spacing_m[0] - 1.0) > 1e-6)
            throw UserError(
                fmt::format("the voxels are not cubic: {:g} x {:g} x {:g} m", grid.spacing_m[0], grid.spacing_m[1], grid.spacing_m[2]),
                {.where = pore_vti.string(), .mend = "resample the image"});
    Container vessel;
    if (container)
        vessel = *container;
    else if (image.notes.contains("container"))
        vessel = container_of_note(image.notes.at("container"), pore_vti);
    else
        throw UserError("the image does not say what its container is",
                        {.where = pore_vti.string(), .mend = "--container cylinder:D,H or box:X,Y,Z[:periodic] (metres)"});
    require_same_size(grid, vessel, pore_vti);
    const Section whole{grid.origin_m[2], grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2]};
    Section section = whole;
    if (section_m.size() == 2)
        section = {section_m[0], section_m[1]};
    else if (image.notes.contains("section"))
        section = section_of_note(image.notes.at("section"), pore_vti);
    const double slack = 0.5 * grid.spacing_m[2];
    if (section.z0 < whole.z0 - slack || section.z1 > whole.z1 + slack || section.length() < grid.spacing_m[2])
        throw UserError(fmt::format("the section from {:g} to {:g} m is not in the image", section.z0, section.z1),
                        {.where = pore_vti.string(), .allowed = fmt::format("{:g} <= z0 < z1 <= {:g} m", whole.z0, whole.z1)});
    LbmConfig one = config;
    one.grids = 1;  // an image has one resolution
    return lbm_json(lbm_permeability([&](double) { return image; }, grid.spacing_m[0], vessel, section, one, true), section, one, folder);
}

Json foam_stage(const Scene& scene, const GeometryConfig& geometry, const FoamConfig& config, const Path& folder) {
    const double cell = config.cell_size_m > 0.0 ? config.cell_size_m
                        : scene.grains
                            ? scene.grain_size_m / 4.0
                            : throw UserError("the cell size is missing", {.mend = "--cell-size (metres), or cell_size_m in [openfoam]"});
    const auto cells = background_cells(scene.container, scene.section, cell);
    const double count = static_cast<double>(cells[0]) * cells[1] * cells[2];
    if (cell > scene.grain_size_m || count > 2e8)
        throw UserError(fmt::format("a background cell of {:g} m does not fit the scene: {} x {} x {} cells, capsule diameter {:g} m", cell,
                                    cells[0], cells[1], cells[2], scene.grain_size_m),
                        {.allowed = "cells smaller than the capsules, at most 2e8 of them", .mend = "the cell size is in metres"});
    const double exact = porosity(scene.solid(), scene.container, scene.section).value;
    const Expectation expected = expect_foam(scene.container, scene.section, cell, exact, config);
    require_memory(expected.memory_bytes, "the OpenFOAM mesh", "take larger cells or a shorter section");

    FoamScene foam{.surface = {}, .container = scene.container, .section = scene.section};
    foam.surface =
        scene.surface
            ? *scene.surface
            : make_surface(*scene.packing, {.deviation_m = geometry.surface_deviation_m, .contact_gap_m = geometry.contact_gap_m}).surface;
    foam.pore_volume_m3 = exact * scene.container.inner_area_m2() * scene.section.length();
    foam.grain_size_m = scene.grain_size_m;
    const double coarsest = cell * (config.meshes == 2 ? config.mesh_ratio : 1.0);
    const double probe =
        scene.container.any_periodic() ? scene.section.length() / std::ceil(scene.section.length() / (0.5 * coarsest)) : 0.5 * coarsest;
    foam.pore_point = find_pore_point(voxelise(scene.solid(), scene.container, scene.section,
                                               plan_voxels(scene.container, scene.section, probe, 0.0, scene.grain_size_m)),
                                      scene.container);
    const FoamResult result = foam_permeability(foam, config, cell, home_folder() / "openfoam_cases", folder);

    const auto mesh_json = [](const FoamMeshResult& mesh) -> Json {
        return {{"cell_size_m", mesh.cell_size_m},
                {"cells", mesh.cells},
                {"max_non_orthogonality_deg", mesh.max_non_orthogonality},
                {"skew_faces", mesh.skew_faces},
                {"mesh_volume_ratio", mesh.mesh_volume_ratio},
                {"iterations", mesh.iterations},
                {"flow_imbalance", mesh.flow_imbalance},
                {"flow_drift", mesh.flow_drift},
                {"permeability_m2", mesh.permeability_m2},
                {"wall_time_s", mesh.wall_time_s},
                {"peak_memory_bytes", mesh.peak_memory_bytes}};
    };
    Json json;
    add_permeability(json, result.permeability_m2, result.interval_m2);
    json["method"] = "OpenFOAM simpleFoam, creeping flow, snappyHexMesh";
    json["repeat_by_hand"] = "cd mesh_fine && ./Allclean && ./Allrun";
    json["interval_meaning"] =
        result.interval_m2 ? "extrapolated from two meshes with order 1.5; the interval spans orders 1 to 2" : "one mesh: no uncertainty";
    json["section_m"] = list(scene.section);
    json["converged"] = true;
    json["cells"] = result.fine.cells;
    json["iterations"] = result.fine.iterations;
    json["fine"] = mesh_json(result.fine);
    json["coarse"] = result.coarse ? mesh_json(*result.coarse) : Json(nullptr);
    json["expected_memory_bytes"] = expected.memory_bytes;
    return json;
}

namespace {

Json geometric_json(const GeometricPaperResult& result, const std::string& geometry) {
    return {{"kind", "geometric_paper"},
            {"geometry", geometry},
            {"tortuosity_geometric_paper", result.value},
            {"standard_error", result.standard_error},
            {"standard_deviation", result.standard_deviation},
            {"paths", result.paths},
            {"slices", result.slices},
            {"rejections_per_point", result.rejections_per_point}};
}

}  // namespace

Json geometric_paper_stage(const Scene& scene, const TortuosityConfig& config) {
    if (!scene.grains)
        throw UserError(
            "the exact dot method needs a packing",
            {.mend =
                 "make slices of the STL file and give their folder: porepack slices, then porepack tortuosity geometric_paper SLICES"});
    return geometric_json(geometric_paper_exact(*scene.grains, scene.container, scene.section, config), "exact");
}

Json geometric_paper_slices_stage(const Path& slices, const TortuosityConfig& config) {
    const SliceStack stack = read_slices(slices);
    Json json = geometric_json(geometric_paper_on_slices(stack, config), "pixels");
    json["pixel_m"] = stack.grid.spacing_m[0];
    return json;
}

Json hydraulic_stage(const Path& flow_vti, const std::vector<double>& section_m) {
    const FlowImage flow = read_flow_image(flow_vti);
    Section section{-1e300, 1e300};
    if (section_m.size() == 2)
        section = {section_m[0], section_m[1]};
    else if (flow.notes.contains("section"))
        section = section_of_note(flow.notes.at("section"), flow_vti);
    const std::string direction = flow.notes.contains("direction") ? flow.notes.at("direction") : "z";
    const int axis = direction == "x" ? 0 : direction == "y" ? 1 : 2;
    return {{"kind", "hydraulic"},
            {"direction", direction},
            {"tortuosity_hydraulic", hydraulic_tortuosity(flow, section, axis)},
            {"uncertainty", nullptr}};
}

Json falling_head_stage(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config, const Path* folder) {
    const FallingHead test(permeability_m2, inertial_permeability_m, config);
    Json json = {{"permeability_m2", permeability_m2},
                 {"inertial_permeability_m", std::isfinite(inertial_permeability_m) ? Json(inertial_permeability_m) : Json("infinite")},
                 {"sample_length_m", config.sample_length_m},
                 {"start_level_m", config.start_level_m},
                 {"levels_m", config.levels_m},
                 {"times_s", Json::array()}};
    for (const double level : config.levels_m) {
        const double time = test.time_at(level);
        if (!std::isfinite(time))
            throw UserError(fmt::format("the time at which the level passes {:g} m is beyond all numbers", level),
                            {.mend = "check k, k_in, the viscosity and gravity: SI units"});
        json["times_s"].push_back(time);
    }
    const double speed = test.speed_at(config.start_level_m);
    json["start_speed_m_per_s"] = speed;
    // Water that falls freely from the start level would be no faster than this.
    const double free_fall = std::sqrt(2.0 * config.gravity_m_per_s2 * (config.start_level_m + config.sample_length_m));
    if (speed > free_fall)
        json["warning"] = fmt::format(
            "the water would start at {:.3g} m/s, faster than it can fall ({:.3g} m/s): Darcy's law alone does not hold here; give an "
            "inertial "
            "permeability",
            speed, free_fall);
    json["equation"] = "Eq. 18, closed form, without the inertia of the water column";
    if (folder != nullptr) {
        std::string text = "time_s,level_m\n";
        const double end = test.time_at(0.0);
        for (int i = 0; i <= 200; ++i) text += fmt::format("{:.8g},{:.8g}\n", end * i / 200, std::max(0.0, test.level_at(end * i / 200)));
        write_text(*folder / "falling_head.csv", text);
    }
    return json;
}

bool draw_picture(const Path& stl, const Path& png, const std::vector<std::string>& more) {
    std::vector<std::string> command = {std::filesystem::read_symlink("/proc/self/exe").string(), "picture",
                                        std::filesystem::absolute(stl).string(), "--output", std::filesystem::absolute(png).string()};
    command.insert(command.end(), more.begin(), more.end());
    const Path log = png.parent_path() / "log.picture";
    const bool drawn = run_program({.command = command, .folder = png.parent_path(), .log = log}).exit_code == 0;
    if (drawn) std::filesystem::remove(log);
    return drawn;
}

Expectation expect_lbm(const Container& container, const Section& section, double voxel_size_m, double grain_size_m, double pores,
                       const GeometryConfig& geometry, const LbmConfig& config) {
    const VoxelPlan plan = plan_voxels(container, section, voxel_size_m, geometry.reservoir_m, grain_size_m);
    const double cells = static_cast<double>(plan.grid.size());
    const double fluid = pores * container.inner_area_m2() * section.length() / std::pow(plan.voxel_size_m, 3);
    Expectation expected{.memory_bytes = lbm_memory_bytes(cells, fluid) + 16.0 * cells};
    // Steps grow with the square of the pores' width in voxels, and with the length; rate of about 8 million a second and thread.
    const double steps = std::max(400.0, 4.0 * std::pow(grain_size_m / plan.voxel_size_m, 2.0)) * 1.2 / config.relaxation_time;
    const double coarse = config.grids == 2 ? 1.0 + std::pow(config.grid_ratio, -5.0) : 1.0;
    expected.wall_time_s = coarse * steps * fluid / (8e6 * thread_count());
    expected.text = fmt::format("{} x {} x {} voxels of {:.4g} m, about {:.2g} fluid nodes", plan.grid.cells[0], plan.grid.cells[1],
                                plan.grid.cells[2], plan.voxel_size_m, fluid);
    return expected;
}

Expectation expect_foam(const Container& container, const Section& section, double cell_size_m, double pores, const FoamConfig& config) {
    const auto block = background_cells(container, section, cell_size_m);
    const double background = pores * container.inner_area_m2() * section.length() / std::pow(cell_size_m, 3);
    const double cells = background * std::pow(2.5, config.surface_level);
    // Measured: 0.45 ms a cell for meshing and solving, 1.6 kB a cell.
    const double coarse = config.meshes == 2 ? 1.0 + std::pow(config.mesh_ratio, -3.0) : 1.0;
    return {.text = fmt::format("background {} x {} x {}, about {:.2g} cells in the finest mesh", block[0], block[1], block[2], cells),
            .memory_bytes = 1e8 + 1600.0 * cells,
            .wall_time_s = coarse * 0.45e-3 * cells};
}

}  // namespace porepack
