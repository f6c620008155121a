// Surface, voxels and slices of the grains: results/{stl,voxelise,slices}/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/interval.hpp"
#include "core/members.hpp"
#include "results/pack.hpp"

namespace porepack::results {

/// The surface of the pores of the section (pores.stl).
struct PoresOfSurface {
    core::Interval section_m;
    double volume_m3 = 0.0, porosity = 0.0;
    std::size_t triangles = 0;
};
template <core::MembersOf<PoresOfSurface> Self, typename Visit>
void visit_members(Self& pores, const Visit& visit) {
    visit("section_m", pores.section_m);
    visit("volume_m3", pores.volume_m3);
    visit("porosity", pores.porosity);
    visit("triangles", pores.triangles);
}

/// The solid between the planes of the section (clipped.stl).
struct ClippedSurface {
    core::Interval section_m;
    double volume_m3 = 0.0;
};
template <core::MembersOf<ClippedSurface> Self, typename Visit>
void visit_members(Self& clipped, const Visit& visit) {
    visit("section_m", clipped.section_m);
    visit("volume_m3", clipped.volume_m3);
}

/// How the surface was made of the grains.
struct SurfaceOfGrains {
    double largest_deviation_m = 0.0, contact_gap_m = 0.0;
    long joined_grains = 0, contacts_joined = 0, thinned_grains = 0;
};
template <core::MembersOf<SurfaceOfGrains> Self, typename Visit>
void visit_members(Self& made, const Visit& visit) {
    visit("largest_deviation_m", made.largest_deviation_m);
    visit("contact_gap_m", made.contact_gap_m);
    visit("joined_grains", made.joined_grains);
    visit("contacts_joined", made.contacts_joined);
    visit("thinned_grains", made.thinned_grains);
}

/// Properties of solid.stl as written, in single precision.
struct Stl {
    static constexpr const char* stage = "stl";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    core::OptionalKey<SurfaceOfGrains> made = {};  ///< not of a user's surface
    std::size_t triangles = 0;
    long shells = 0;
    bool closed = false, outward = false, self_intersecting = false;
    double volume_m3 = 0.0, area_m2 = 0.0;
    // Of grains in a container without periodic faces.
    core::OptionalKey<double> exact_volume_m3 = {};
    core::OptionalKey<double> volume_error = {};     ///< relative
    core::OptionalKey<double> porosity_change = {};  ///< of the bed, by facets and bridges
    core::OptionalKey<PoresOfSurface> pores = {};
    core::OptionalKey<ClippedSurface> clipped = {};
    core::OptionalKey<std::size_t> grain_files = {};
    core::OptionalKey<std::string> unit_of_solid_mm = {};
    core::OptionalKey<BedPorosity> bed = {};  ///< of a user's surface
};
template <core::MembersOf<Stl> Self, typename Visit>
void visit_members(Self& stl, const Visit& visit) {
    visit("", stl.made);
    visit("exact_volume_m3", stl.exact_volume_m3);
    visit("triangles", stl.triangles);
    visit("shells", stl.shells);
    visit("closed", stl.closed);
    visit("outward", stl.outward);
    visit("self_intersecting", stl.self_intersecting);
    visit("volume_m3", stl.volume_m3);
    visit("area_m2", stl.area_m2);
    visit("volume_error", stl.volume_error);
    visit("porosity_change", stl.porosity_change);
    visit("pores", stl.pores);
    visit("clipped", stl.clipped);
    visit("grain_files", stl.grain_files);
    visit("unit_of_solid_mm", stl.unit_of_solid_mm);
    visit("", stl.bed);
}

struct Voxelise {
    static constexpr const char* stage = "voxelise";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 4;
    core::OptionalKey<double> film_thickness_m = {};  ///< on all grains
    core::OptionalKey<double> closing_radius_m = {};  ///< of the menisci between them
    double voxel_size_m = 0.0;
    std::array<int, 3> cells{};
    core::Interval section_m, bed_m;
    std::array<double, 2> buffers_m{};
    double reservoir_m = 0.0;
    double porosity_of_voxels = 0.0;
    double porosity = 0.0;                              ///< of the section, exact
    double porosity_uncertainty = 0.0;                  ///< a standard uncertainty; NaN without exact walls
    std::optional<core::Interval> porosity_interval{};  ///< of 95 %
    double expected_memory_bytes = 0.0;
};
template <core::MembersOf<Voxelise> Self, typename Visit>
void visit_members(Self& voxels, const Visit& visit) {
    visit("film_thickness_m", voxels.film_thickness_m);
    visit("closing_radius_m", voxels.closing_radius_m);
    visit("voxel_size_m", voxels.voxel_size_m);
    visit("cells", voxels.cells);
    visit("section_m", voxels.section_m);
    visit("bed_m", voxels.bed_m);
    visit("buffers_m", voxels.buffers_m);
    visit("reservoir_m", voxels.reservoir_m);
    visit("porosity_of_voxels", voxels.porosity_of_voxels);
    visit("porosity", voxels.porosity);
    visit("porosity_uncertainty", voxels.porosity_uncertainty);
    visit("porosity_interval", voxels.porosity_interval);
    visit("expected_memory_bytes", voxels.expected_memory_bytes);
}

struct Slices {
    static constexpr const char* stage = "slices";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    int slices = 0;
    double spacing_m = 0.0, pixel_m = 0.0;
    core::Interval section_m;
};
template <core::MembersOf<Slices> Self, typename Visit>
void visit_members(Self& slices, const Visit& visit) {
    visit("slices", slices.slices);
    visit("spacing_m", slices.spacing_m);
    visit("pixel_m", slices.pixel_m);
    visit("section_m", slices.section_m);
}

}  // namespace porepack::results
