#include "converters/simplify.hpp"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "converters/cgal_mesh.hpp"
#include "converters/surface.hpp"
#include "converters/uses.hpp"

namespace porepack::converters {
namespace sms = CGAL::Surface_mesh_simplification;

std::optional<TriangleSurface> largest_part(const TriangleSurface& surface, long faces) {
    std::optional<Mesh> mesh = mesh_of(surface);
    if (!mesh) return std::nullopt;
    CGAL::Polygon_mesh_processing::keep_largest_connected_components(*mesh, 1);
    // A closed surface has three edges for two triangles.
    if (static_cast<long>(mesh->number_of_faces()) > faces)
        sms::edge_collapse(*mesh, sms::Count_stop_predicate<Mesh>(static_cast<std::size_t>(3 * faces / 2 + 1)),
                           CGAL::parameters::filter(sms::Bounded_normal_change_filter<>()));
    mesh->collect_garbage();
    TriangleSurface part;
    append(part, *mesh);
    const SurfaceCheck check = check_surface(part);
    if (!check.fault.empty() || check.shells != 1 || !(check.volume_m3 > 0.0)) return std::nullopt;
    return part;
}

}  // namespace porepack::converters
