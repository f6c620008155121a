// Table [geometry] of case.toml.
#pragma once

#include <array>
#include <vector>

#include "core/choice.hpp"
#include "record/config.hpp"

namespace porepack::converters {

/// Meaning, unit, range and default of each key: see describe(). 0 stands for "chosen automatically" where that is allowed.
struct GeometryConfig {
    double voxel_size_m = 0.0;
    double surface_deviation_m = 0.0;
    double contact_gap_m = 0.0;
    std::vector<double> section_m;
    double trim_m = 0.0;
    double film_thickness_m = 0.0;
    double film_volume_fraction = 0.0;
    double closing_radius_m = 0.0;
    double reservoir_m = 0.0;
    double slice_spacing_m = 2e-4;
    double slice_pixel_m = 2e-4;
};

/// Other formats of solid.stl.
enum class SurfaceFiles { nothing, ply, vtp, both };
constexpr std::array<core::Choice<SurfaceFiles>, 4> choices_of(SurfaceFiles) {
    return {{{SurfaceFiles::nothing, "nothing"}, {SurfaceFiles::ply, "ply"}, {SurfaceFiles::vtp, "vtp"}, {SurfaceFiles::both, "both"}}};
}

/// Table [stl]: what the stl stage writes beside solid.stl, which is always the grains in metres.
struct StlConfig {
    bool pores = false;
    bool clip = false;
    bool one_file_per_grain = false;
    SurfaceFiles also = SurfaceFiles::nothing;
    bool millimetres = false;
};

inline void describe(record::ConfigVisitor& v, StlConfig& c) {
    v.boolean("pores", c.pores,
              "pores.stl: the boundary of the pore space of the section inside the container, with regions inlet, outlet, wall, grains");
    v.boolean("clip", c.clip, "clipped.stl: the grains clipped at the section's planes, closed");
    v.renamed("one_file_a_grain", "one_file_per_grain");
    v.boolean("one_file_per_grain", c.one_file_per_grain, "grains/grain_00001.stl ...: one file per grain");
    v.choice("also", c.also, "solid.ply, solid.vtp: the same surface in other formats");
    v.boolean("millimetres", c.millimetres, "solid_mm.stl: the same surface in millimetres, for 3D printing");
}

inline void describe(record::ConfigVisitor& v, GeometryConfig& c) {
    v.number("voxel_size_m", c.voxel_size_m, record::length_range_or_auto(),
             "edge length of the cubic voxels; auto: the smallest thickness of the grains / 10. Adjusted so that the section is a whole "
             "number of "
             "voxels");
    v.number(
        "surface_deviation_m", c.surface_deviation_m, record::length_range_or_auto(),
        "maximum distance between the triangles and the exact surface; auto: 0.5 % of the capsule's diameter, or of the thickness of a "
        "grain with faces; 2 % with grains from meshes, whose inner edges may deviate by more");
    v.number("contact_gap_m", c.contact_gap_m, record::length_range_or_auto(),
             "grains that overlap, or whose gap is below this length, become one body; if the surface of other grains intersects itself "
             "after rounding to single precision, these grains are made thinner by this length; auto: 1e-4 of the capsule's diameter, "
             "and 10 and 100 times that where faults remain");
    v.numbers("section_m", c.section_m, {2, 2}, record::not_negative(),
              "z0 and z1 of the section that is evaluated; auto: the bed without a length of trim_m at each end");
    v.number("trim_m", c.trim_m, record::length_range_or_auto(),
             "length removed at each end of the bed; auto: 30 mm or one maximum Feret diameter of a grain, whichever is smaller");
    v.number("film_thickness_m", c.film_thickness_m, record::length_range_or_auto(),
             "thickness of a film (binder) on all grains of the packing, at rest; it counts as solid in all that follows; auto: none");
    v.number("film_volume_fraction", c.film_volume_fraction, {.low = 0.0, .high = 0.9, .zero_is_auto = true},
             "the same by its volume over that of the bed, without what overlaps; auto: as film_thickness_m says");
    v.number("closing_radius_m", c.closing_radius_m, record::length_range_or_auto(),
             "menisci between the grains of a packing, as of a binder that wets them: what no ball of this radius reaches between them is "
             "solid for the flow, tortuosities and pores; auto: none. solid.stl has none, and a case with menisci none by OpenFOAM");
    v.number("reservoir_m", c.reservoir_m, record::between(0.0, 1e6),
             "length of the container without grains that is added beyond each end of the section in flow computations");
    v.number("slice_spacing_m", c.slice_spacing_m, record::length_range(), "distance between two slices");
    v.number("slice_pixel_m", c.slice_pixel_m, record::length_range(), "edge length of the square pixels of the slices");
}

}  // namespace porepack::converters
