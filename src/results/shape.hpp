// The grain: results/shape/result.json, and `porepack shape`.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/members.hpp"
#include "results/tensor.hpp"

namespace porepack::results {

/// A symmetric tensor with its main axes.
struct Inertia {
    Tensor inertia_kg_m2{};
    std::array<double, 3> principal_moments_kg_m2{};
    Tensor principal_axes{};  ///< one per row
};
template <core::MembersOf<Inertia> Self, typename Visit>
void visit_members(Self& inertia, const Visit& visit) {
    visit("inertia_kg_m2", inertia.inertia_kg_m2);
    visit("principal_moments_kg_m2", inertia.principal_moments_kg_m2);
    visit("principal_axes", inertia.principal_axes);
}

/// Where the grain has a cavity that is filled, or is open: the measures of the other case, too.
struct CavityMeasures {
    double volume_filled_m3 = 0.0, volume_open_m3 = 0.0, surface_area_filled_m2 = 0.0, surface_area_open_m2 = 0.0;
};
template <core::MembersOf<CavityMeasures> Self, typename Visit>
void visit_members(Self& cavity, const Visit& visit) {
    visit("volume_filled_m3", cavity.volume_filled_m3);
    visit("volume_open_m3", cavity.volume_open_m3);
    visit("surface_area_filled_m2", cavity.surface_area_filled_m2);
    visit("surface_area_open_m2", cavity.surface_area_open_m2);
}

/// One grain of spherocylinders; all bodies of a surface; or the means over a mixture's grains, by number.
struct Shape {
    static constexpr const char* stage = "shape";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    std::string kind;
    double volume_m3 = 0.0, surface_area_m2 = 0.0;
    /// Of a mixture, the one that gives its specific surface: 6 V/A = sphericity times the equal-volume diameter. Not of a surface.
    core::OptionalKey<double> sphericity = {};
    core::OptionalKey<double> equal_volume_diameter_m = {};  ///< not of a surface
    core::OptionalKey<double> relative_error = {};           ///< of the volume; not of a surface
    // Not of a mixture.
    core::OptionalKey<double> convexity = {}, convex_hull_volume_m3 = {}, convex_hull_area_m2 = {};
    core::OptionalKey<std::array<double, 3>> centre_of_mass_m = {};
    core::OptionalKey<double> density_kg_per_m3 = {}, mass_kg = {};
    core::OptionalKey<Inertia> inertia = {};
    core::OptionalKey<double> bounding_radius_m = {}, maximum_feret_diameter_m = {};
    // Of spherocylinders.
    core::OptionalKey<std::string> cavity = {};
    core::OptionalKey<double> diameter_m = {}, length_m = {};  ///< of a preset
    core::OptionalKey<std::size_t> capsules = {};
    core::OptionalKey<double> cavity_volume_m3 = {}, cavity_area_m2 = {};
    core::OptionalKey<CavityMeasures> with_cavity = {};
    // Of a grain with faces: its rounding, and what that changes. `sharp`: with sharp edges, and the same volume.
    core::OptionalKey<double> rounding_m = {}, scale_of_sizes = {}, sharp_surface_area_m2 = {}, sharp_sphericity = {};
    /// Of a mesh: triangles of the file and of the grain, its area there, and the distance of the two surfaces, in both directions.
    core::OptionalKey<long> faces_of_file = {}, faces = {};
    core::OptionalKey<double> surface_area_of_file_m2 = {}, largest_deviation_m = {}, rms_deviation_m = {};
    // Of a surface.
    core::OptionalKey<long> shells = {};
    core::OptionalKey<std::array<double, 3>> low_m = {}, high_m = {};
    core::OptionalKey<double> sphericity_of_all = {};  ///< of several bodies together: no sphericity of a grain
    // Of a mixture.
    core::OptionalKey<std::vector<Shape>> components = {};
    core::OptionalKey<double> number_fraction = {};  ///< of a component
};
template <core::MembersOf<Shape> Self, typename Visit>
void visit_members(Self& shape, const Visit& visit) {
    visit("kind", shape.kind);
    visit("cavity", shape.cavity);
    visit("diameter_m", shape.diameter_m);
    visit("length_m", shape.length_m);
    visit("capsules", shape.capsules);
    visit("rounding_m", shape.rounding_m);
    visit("scale_of_sizes", shape.scale_of_sizes);
    visit("sharp_surface_area_m2", shape.sharp_surface_area_m2);
    visit("sharp_sphericity", shape.sharp_sphericity);
    visit("faces_of_file", shape.faces_of_file);
    visit("faces", shape.faces);
    visit("surface_area_of_file_m2", shape.surface_area_of_file_m2);
    visit("largest_deviation_m", shape.largest_deviation_m);
    visit("rms_deviation_m", shape.rms_deviation_m);
    visit("shells", shape.shells);
    visit("components", shape.components);
    visit("volume_m3", shape.volume_m3);
    visit("surface_area_m2", shape.surface_area_m2);
    visit("low_m", shape.low_m);
    visit("high_m", shape.high_m);
    visit("sphericity", shape.sphericity);
    visit("convexity", shape.convexity);
    visit("convex_hull_volume_m3", shape.convex_hull_volume_m3);
    visit("convex_hull_area_m2", shape.convex_hull_area_m2);
    visit("equal_volume_diameter_m", shape.equal_volume_diameter_m);
    visit("cavity_volume_m3", shape.cavity_volume_m3);
    visit("cavity_area_m2", shape.cavity_area_m2);
    visit("", shape.with_cavity);
    visit("centre_of_mass_m", shape.centre_of_mass_m);
    visit("density_kg_per_m3", shape.density_kg_per_m3);
    visit("mass_kg", shape.mass_kg);
    visit("", shape.inertia);
    visit("bounding_radius_m", shape.bounding_radius_m);
    visit("maximum_feret_diameter_m", shape.maximum_feret_diameter_m);
    visit("relative_error", shape.relative_error);
    visit("sphericity_of_all", shape.sphericity_of_all);
    visit("number_fraction", shape.number_fraction);
}

}  // namespace porepack::results
