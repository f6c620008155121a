#include "analysis/shape.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "analysis/uses.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "inputs/mesh_grains.hpp"
#include "report/picture.hpp"

namespace porepack::analysis {
namespace {

std::array<double, 3> array_of(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

results::Inertia inertia_of(const Eigen::Matrix3d& inertia) {
    results::Inertia found;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    found.principal_moments_kg_m2 = array_of(axes.eigenvalues());
    for (int i = 0; i < 3; ++i) {
        found.inertia_kg_m2[static_cast<std::size_t>(i)] = array_of(inertia.row(i).transpose());
        found.principal_axes[static_cast<std::size_t>(i)] = array_of(axes.eigenvectors().col(i));
    }
    return found;
}

// The mixture's own numbers are means over the grains, by number; its sphericity is the one that gives the mixture's specific
// surface (6 V/A = sphericity times the equal-volume diameter), as the Carman-Kozeny equation requires.
results::Shape measure_mixture(const ShapeConfig& config, double density, const Path& folder) {
    results::Shape mixture{
        .kind = std::string(name_of(ShapeKind::mixture)), .relative_error = 0.0, .components = std::vector<results::Shape>()};
    (void)make_shapes(inputs::with_mesh_grains(config, folder));  // its errors are reported before anything is measured
    for (const auto& part : config.component) {
        results::Shape& component = mixture.components->emplace_back(measure_shape(part, density, folder));
        component.number_fraction = part.number_fraction;
        mixture.volume_m3 += part.number_fraction * component.volume_m3;
        mixture.surface_area_m2 += part.number_fraction * component.surface_area_m2;
        mixture.relative_error = std::max(*mixture.relative_error, *component.relative_error);
    }
    const double volume = mixture.volume_m3;
    mixture.sphericity = std::cbrt(36.0 * std::numbers::pi * volume * volume) / mixture.surface_area_m2;
    mixture.equal_volume_diameter_m = std::cbrt(6.0 * volume / std::numbers::pi);
    return mixture;
}

}  // namespace

results::Shape measure_shape(const ShapeConfig& given, double density, const Path& folder) {
    const ShapeConfig config = inputs::without_library(given, folder);
    if (config.kind == ShapeKind::mixture) return measure_mixture(config, density, folder);
    std::optional<FacedGrain> faced;
    if (has_faces(config.kind)) faced = make_faced(config);
    std::optional<converters::MeshGrain> mesh;
    if (config.kind == ShapeKind::mesh) mesh = inputs::read_mesh_grain(config, folder);
    const Shape shape = faced  ? Shape{.id = std::string(name_of(config.kind)), .body = faced->body}
                        : mesh ? Shape{.id = "mesh", .body = mesh->body}
                               : make_shape(config);
    const ShapeMeasures m = measure(shape);
    const SurfaceSizes convex = hull(shape);
    results::Shape found{.kind = std::string(name_of(config.kind)),
                         .volume_m3 = m.volume_m3,
                         .surface_area_m2 = m.surface_area_m2,
                         .sphericity = m.sphericity,
                         .equal_volume_diameter_m = std::cbrt(6.0 * m.volume_m3 / std::numbers::pi),
                         .relative_error = m.relative_error,
                         .convexity = std::min(1.0, m.volume_m3 / convex.volume_m3),
                         .convex_hull_volume_m3 = convex.volume_m3,
                         .convex_hull_area_m2 = convex.surface_area_m2,
                         .centre_of_mass_m = array_of(m.centre_of_mass_m),
                         .density_kg_per_m3 = density,
                         .mass_kg = density * m.volume_m3,
                         .inertia = inertia_of(density * m.inertia_per_density_m5),
                         .bounding_radius_m = m.bounding_radius_m,
                         .maximum_feret_diameter_m = m.maximum_feret_diameter_m};
    if (faced) {
        found.rounding_m = faced->body->rounding();
        found.scale_of_sizes = faced->scale;
        found.sharp_surface_area_m2 = faced->sharp_area_m2;
        found.sharp_sphericity = faced->sharp_sphericity;
        return found;
    }
    if (mesh) {
        found.rounding_m = mesh->body->rounding();
        found.faces_of_file = mesh->faces_before;
        found.faces = mesh->faces;
        found.surface_area_of_file_m2 = mesh->area_before_m2;
        found.largest_deviation_m = mesh->largest_deviation_m;
        found.rms_deviation_m = mesh->rms_deviation_m;
        return found;
    }
    found.cavity = std::string(name_of(shape.cavity));
    found.capsules = shape.capsules.size();
    found.cavity_volume_m3 = m.cavity_volume_m3;
    found.cavity_area_m2 = m.cavity_area_m2;
    if (config.kind != ShapeKind::capsules) {
        found.diameter_m = 2.0 * shape.capsules.front().radius;
        found.length_m = (shape.capsules.front().b - shape.capsules.front().a).norm();
    }
    if (m.cavity_volume_m3 > 0.0) {
        const bool filled = shape.cavity == Cavity::filled;
        found.with_cavity = {.volume_filled_m3 = m.volume_m3 + (filled ? 0.0 : m.cavity_volume_m3),
                             .volume_open_m3 = m.volume_m3 - (filled ? m.cavity_volume_m3 : 0.0),
                             .surface_area_filled_m2 = m.surface_area_m2 - (filled ? 0.0 : m.cavity_area_m2),
                             .surface_area_open_m2 = m.surface_area_m2 + (filled ? m.cavity_area_m2 : 0.0)};
    }
    return found;
}

void write_mesh_grain(const ShapeConfig& config, const Path& folder, const Path& output) {
    const converters::MeshGrain grain = inputs::read_mesh_grain(config, folder);
    const double width = 2.0 * std::max(grain.body->reach_from(Vec3::Zero()), grain.body->maximum_feret_diameter() / 2.0);
    Packing alone{.container = vessels::make_box({width, width, width}),
                  .shapes = {{.id = "mesh", .body = grain.body}},
                  .bodies = {{.position_m = Vec3::Constant(width / 2.0)}}};
    const double deviation = 0.002 * width;
    const TriangleSurface after = make_surface(alone, {.deviation_m = std::min(deviation, 0.05 * grain.body->thickness())}).surface;
    TriangleSurface at_origin = after, both = grain.surface;
    const auto first = static_cast<int>(both.points.size());
    const Quaternion turned(Eigen::AngleAxisd(0.7, Vec3::UnitX()) * Eigen::AngleAxisd(0.5, Vec3::UnitZ()));  // so that holes are seen
    const auto turn = [&](const std::array<double, 3>& p, double right) {
        const Vec3 q = turned * Vec3(p[0], p[1], p[2]);
        return std::array{q.x() + right, q.y(), q.z()};
    };
    for (auto& p : both.points) p = turn(p, 0.0);
    for (auto& p : at_origin.points) {
        for (double& x : p) x -= width / 2.0;
        both.points.push_back(turn(p, 1.1 * width));
    }
    for (const auto& t : after.triangles) both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    io::write_stl(output / "grain.stl", at_origin);
    io::write_stl(output / "before_and_after.stl", both);
    if (!report::draw_picture(output / "before_and_after.stl", output / "before_and_after.png", {"--front"}))
        log_warning("no picture of the grain: see " + (output / "log.picture").string());
}

// The correlations need the sphericity of one grain, which several bodies together do not have.
results::Shape measure_surface_shape(const TriangleSurface& surface, const std::string& name, double density) {
    const SurfaceCheck check = check_surface(surface);
    require_sound(check, name);
    const SurfaceMeasures m = measure_surface(surface);
    return {.kind = "surface",
            .volume_m3 = m.volume_m3,
            .surface_area_m2 = m.area_m2,
            .convexity = std::min(1.0, m.volume_m3 / m.hull_volume_m3),
            .convex_hull_volume_m3 = m.hull_volume_m3,
            .convex_hull_area_m2 = m.hull_area_m2,
            .centre_of_mass_m = array_of(m.centre_of_mass_m),
            .density_kg_per_m3 = density,
            .mass_kg = density * m.volume_m3,
            .inertia = inertia_of(density * m.inertia_per_density_m5),
            .bounding_radius_m = m.bounding_radius_m,
            .maximum_feret_diameter_m = m.maximum_feret_diameter_m,
            .shells = check.shells,
            .low_m = array_of(check.low),
            .high_m = array_of(check.high),
            .sphericity_of_all = m.sphericity};
}

}  // namespace porepack::analysis
