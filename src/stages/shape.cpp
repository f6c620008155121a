// The grain itself: volume, surface, sphericity, inertia.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "converters/surface.hpp"
#include "core/error.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace io;
using namespace shapes;
using namespace converters;
using namespace lbm;
using namespace pipeline;
namespace {

Json mixture_json(const ShapeConfig& config, double density);

void add_inertia(Json& json, const Eigen::Matrix3d& inertia) {
    json["inertia_kg_m2"] = Json::array();
    for (int row = 0; row < 3; ++row) json["inertia_kg_m2"].push_back(json_of(Vec3(inertia.row(row).transpose())));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    json["principal_moments_kg_m2"] = json_of(Vec3(axes.eigenvalues()));
    json["principal_axes"] = Json::array();
    for (int i = 0; i < 3; ++i) json["principal_axes"].push_back(json_of(Vec3(axes.eigenvectors().col(i))));
}

}  // namespace

Json measure_shape(const ShapeConfig& config, double density) {
    if (config.kind == ShapeKind::mixture) return mixture_json(config, density);
    const Shape shape = make_shape(config);
    const ShapeMeasures m = measure(shape);
    Json json = {{"kind", name_of(config.kind)}, {"cavity", name_of(shape.cavity)}};
    if (config.kind != ShapeKind::capsules) {
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
    json["centre_of_mass_m"] = json_of(m.centre_of_mass_m);
    json["density_kg_per_m3"] = density;
    json["mass_kg"] = density * m.volume_m3;
    add_inertia(json, density * m.inertia_per_density_m5);
    json["bounding_radius_m"] = m.bounding_radius_m;
    json["maximum_feret_diameter_m"] = m.maximum_feret_diameter_m;
    keep_old_name(json, "span_m", "maximum_feret_diameter_m");
    json["relative_error"] = m.relative_error;
    return json;
}

namespace {

// The mixture's own numbers are means over the grains, by number; its sphericity is the one that gives the mixture's specific
// surface (6 V/A = sphericity times the equal-volume diameter), as the Carman-Kozeny equation requires.
Json mixture_json(const ShapeConfig& config, double density) {
    Json json = {{"kind", "mixture"}, {"components", Json::array()}};
    double volume = 0.0, area = 0.0, error = 0.0;
    (void)make_shapes(config);  // its errors are reported before anything is measured
    for (const auto& part : config.component) {
        Json component = measure_shape(part, density);
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

Json measure_surface_shape(const Path& stl, double unit_m, double density) {
    const TriangleSurface surface = read_stl(stl, unit_m);
    const SurfaceCheck check = check_surface(surface);
    require_sound(check, stl.string());
    const SurfaceMeasures m = measure_surface(surface);
    Json json = {{"kind", "stl"},
                 {"shells", check.shells},
                 {"volume_m3", m.volume_m3},
                 {"surface_area_m2", m.area_m2},
                 {"low_m", json_of(check.low)},
                 {"high_m", json_of(check.high)},
                 {"convexity", std::min(1.0, m.volume_m3 / m.hull_volume_m3)},
                 {"convex_hull_volume_m3", m.hull_volume_m3},
                 {"convex_hull_area_m2", m.hull_area_m2},
                 {"centre_of_mass_m", json_of(m.centre_of_mass_m)},
                 {"density_kg_per_m3", density},
                 {"mass_kg", density * m.volume_m3},
                 {"bounding_radius_m", m.bounding_radius_m},
                 {"maximum_feret_diameter_m", m.maximum_feret_diameter_m}};
    keep_old_name(json, "span_m", "maximum_feret_diameter_m");
    add_inertia(json, density * m.inertia_per_density_m5);
    // The correlations need the sphericity of one grain, which several bodies together do not have.
    json["sphericity_of_all"] = m.sphericity;
    return json;
}

Stage make_shape_stage(const Case& c) {
    const double density = c.settings.packing.density_kg_per_m3;
    Stage stage{.name = "shape", .configuration = c.settings.resolved_tables({"shape"})};
    if (c.from_stl()) {
        const Path file = c.resolve(c.settings.shape.file);
        stage.files = {file};
        stage.run = [=, unit_m = c.settings.shape.unit_m](const Path&) { return measure_surface_shape(file, unit_m, density); };
    } else {
        stage.run = [=, shape = c.settings.shape](const Path&) { return measure_shape(shape, density); };
    }
    return stage;
}

}  // namespace porepack::stages
