#include "analysis/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "analysis/porosity.hpp"
#include "analysis/uses.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"

namespace porepack::analysis {
namespace {

// Default: 0.5 % of the smallest thickness of the grains.
double surface_deviation(const PoreSpace& space, const GeometryConfig& geometry) {
    return geometry.surface_deviation_m > 0.0 ? geometry.surface_deviation_m : 0.005 * space.grain_size_m;
}

// The files requested by the table [stl] besides solid.stl.
void write_extra_surfaces(const PoreSpace& space, double deviation, const StlConfig& extras, const TriangleSurface& solid,
                          const Path& folder, results::Stl& result) {
    const double section_volume = space.container.vessel().mean_area(space.section.interval()) * space.section.length();
    if (extras.pores) {
        const PoreSurface pores = make_pore_surface(solid, space.container, space.section, deviation);
        write_stl_regions(folder / "pores.stl", pores.surface, pores.region, {"inlet", "outlet", "wall", "grains"});
        const SurfaceMeasures measures = measure_surface(pores.surface);
        result.pores = {.section_m = space.section.interval(),
                        .volume_m3 = measures.volume_m3,
                        .porosity = measures.volume_m3 / section_volume,
                        .triangles = pores.surface.triangles.size()};
    }
    if (extras.clip) {
        const TriangleSurface clipped = clip_surface(solid, space.section);
        write_stl(folder / "clipped.stl", clipped);
        result.clipped = {.section_m = space.section.interval(), .volume_m3 = measure_surface(clipped).volume_m3};
    }
    if (extras.one_file_per_grain) {
        if (!space.packing()) throw UserError("an STL file's grains cannot be told apart", {.fix = "remove one_file_per_grain"});
        make_folder(folder / "grains");
        const Container& container = space.packing()->container;
        Packing one{.container = container.any_periodic() ? vessels::make_box(container.size()) : container,
                    .shapes = space.packing()->shapes,
                    .bodies = {}};
        for (std::size_t b = 0; b < space.packing()->bodies.size(); ++b) {
            one.bodies = {space.packing()->bodies[b]};
            write_stl(folder / "grains" / fmt::format("grain_{:05}.stl", b + 1), make_surface(one, {.deviation_m = deviation}).surface);
        }
        result.grain_files = space.packing()->bodies.size();
    }
    if (extras.also == SurfaceFiles::ply || extras.also == SurfaceFiles::both) write_ply(folder / "solid.ply", solid);
    if (extras.also == SurfaceFiles::vtp || extras.also == SurfaceFiles::both) write_vtp(folder / "solid.vtp", solid);
    if (extras.millimetres) {
        TriangleSurface scaled = solid;
        for (auto& p : scaled.points)
            for (double& x : p) x *= 1000.0;
        write_stl(folder / "solid_mm.stl", scaled, "porepack; unit: millimetre");
        result.unit_of_solid_mm = "millimetre";
    }
}

// Each triangle in the same place, with the same coordinates.
bool same_triangles(const TriangleSurface& p, const TriangleSurface& q) {
    const auto corner = [](const TriangleSurface& surface, std::size_t t, std::size_t c) {
        return surface.points[static_cast<std::size_t>(surface.triangles[t][c])];
    };
    if (p.triangles.size() != q.triangles.size() || p.points.size() != q.points.size()) return false;
    for (std::size_t t = 0; t < p.triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c)
            if (corner(p, t, c) != corner(q, t, c)) return false;
    return true;
}

}  // namespace

results::Stl write_surfaces(const PoreSpace& space, const GeometryConfig& geometry, const StlConfig& extras, const Path& folder) {
    if (!space.packing() && !space.surface())
        throw UserError("a surface is made of a packing or an STL file, not of an image",
                        {.where = space.source, .fix = "porepack image segment writes solid.stl"});
    results::Stl result;
    const Path file = folder / "solid.stl";
    std::optional<TriangleSurface> checked;
    SurfaceCheck check;
    if (space.packing()) {
        SurfaceResult made = make_surface(*space.packing(), surface_options(geometry));
        write_stl(file, made.surface);
        const shapes::Bounds bounds = space.grains()->bounds();  // grains may reach through the ends of a scan
        const Section all{std::min(0.0, bounds.low.z()), std::max(space.container.height(), bounds.high.z())};
        const double solid = (1.0 - porosity(*space.grains(), space.container, all).value) *
                             space.container.vessel().mean_area(all.interval()) * all.length();
        result.made = {.largest_deviation_m = made.deviation_m,
                       .contact_gap_m = made.contact_gap_m,
                       .joined_grains = made.joined_grains,
                       .contacts_joined = made.bridges,
                       .thinned_grains = made.shrunk_grains};
        if (!space.container.any_periodic()) result.exact_volume_m3 = solid;
        checked = std::move(made.surface);
        check = std::move(made.check);
    } else {
        write_stl(file, *space.surface());
    }
    // The reported properties are checked on the file as written, in single precision.
    const TriangleSurface written = read_stl(file);
    if (!checked || !same_triangles(*checked, written)) check = check_surface(written);
    if (!check.fault.empty())
        throw NumericalError("the surface written is not sound: " + check.fault,
                             {.where = file.string(), .fix = "change surface_deviation_m or contact_gap_m"});
    result.triangles = (std::filesystem::file_size(file) - 84) / 50;
    result.shells = check.shells;
    result.closed = check.closed;
    result.outward = check.outward;
    result.self_intersecting = check.self_intersecting;
    result.volume_m3 = check.volume_m3;
    result.area_m2 = check.area_m2;
    if (result.exact_volume_m3) {
        const double exact = *result.exact_volume_m3;
        result.volume_error = check.volume_m3 / exact - 1.0;
        // Facets and bridges together, relative to the bed.
        const double height = std::min(space.bed_top_m, space.container.height());
        result.porosity_change = (exact - check.volume_m3) / (space.container.vessel().mean_area({0.0, height}) * height);
    }
    write_extra_surfaces(space, surface_deviation(space, geometry), extras, written, folder, result);
    if (!space.packing()) result.bed = bed_porosity(space);
    return result;
}

}  // namespace porepack::analysis
