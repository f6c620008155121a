#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/boost/graph/Face_filtered_graph.h>
#include <CGAL/boost/graph/copy_face_graph.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "converters/cgal_mesh.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

namespace porepack::converters {
using namespace core;
using namespace io;
using namespace shapes;
using namespace packing;
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

std::string place_text(const std::array<double, 3>& p) {
    return fmt::format("near ({:.6g}, {:.6g}, {:.6g}) m", p[0], p[1], p[2]);
}

// Every edge of a closed surface has exactly two triangles that run along it in opposite directions.
std::string edge_fault(const TriangleSurface& surface, SurfaceCheck& check) {
    std::vector<std::pair<std::pair<int, int>, int>> sides;  // of each edge, with its direction
    sides.reserve(3 * surface.triangles.size());
    for (const auto& triangle : surface.triangles)
        for (std::size_t c = 0; c < 3; ++c) {
            const int from = triangle[c], to = triangle[(c + 1) % 3];
            sides.emplace_back(std::minmax(from, to), from < to ? 1 : -1);
        }
    std::sort(sides.begin(), sides.end());
    long open_edges = 0, twisted = 0;
    std::pair<int, int> first_open{}, first_twisted{};
    for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
        const auto edge = sides[i].first;
        int sum = 0;
        for (; end < sides.size() && sides[end].first == edge; ++end) sum += sides[end].second;
        const std::size_t count = end - i;
        const auto& p = surface.points[static_cast<std::size_t>(edge.first)];
        if (count != 2 || sum != 0) check.fault_places.emplace_back(p[0], p[1], p[2]);
        if (count % 2 == 1 && open_edges++ == 0) first_open = edge;
        if (count % 2 == 0 && sum != 0 && twisted++ == 0) first_twisted = edge;
    }
    check.closed = open_edges == 0;
    const auto at = [&](const std::pair<int, int>& edge) { return place_text(surface.points[static_cast<std::size_t>(edge.first)]); };
    if (open_edges > 0) return fmt::format("the surface is open: {} edges have no neighbour, the first {}", open_edges, at(first_open));
    if (twisted > 0)
        return fmt::format("neighbouring triangles have opposite orientations at {} edges, the first {}", twisted, at(first_twisted));
    return {};
}

// Names the first shell with the wrong orientation for the number of shells around it.
template <typename ShellMap>
std::string misplaced_shell(const Mesh& mesh, const ShellMap& shell, long shells) {
    std::vector<Mesh> parts(static_cast<std::size_t>(shells));
    for (std::size_t s = 0; s < parts.size(); ++s) {
        const CGAL::Face_filtered_graph<Mesh> part(mesh, s, shell);
        CGAL::copy_face_graph(part, parts[s]);
    }
    for (const auto& part : parts) {
        int depth = 0;
        const Point& corner = part.point(*part.vertices().begin());
        for (const auto& other : parts)
            if (&other != &part && CGAL::Side_of_triangle_mesh<Mesh, Kernel>(other)(corner) == CGAL::ON_BOUNDED_SIDE) ++depth;
        const bool outward = pmp::volume(part) > 0.0;
        if (outward == (depth % 2 == 0)) continue;
        return fmt::format("the shell {} is turned {} although {} shells enclose it", place_text({corner.x(), corner.y(), corner.z()}),
                           outward ? "outward" : "inward", depth);
    }
    return "the orientations of the shells contradict each other";
}

// Pairs of faces that cross each other. Slabs of the surface are searched in parallel: a face belongs to all slabs that it reaches.
std::set<std::pair<Mesh::Face_index, Mesh::Face_index>> crossings_of(const Mesh& mesh) {
    std::vector<std::pair<double, double>> reach;  // of the faces, in z
    std::vector<double> middles;
    for (const auto face : mesh.faces()) {
        const auto box = pmp::face_bbox(face, mesh);
        reach.emplace_back(box.zmin(), box.zmax());
        middles.push_back(0.5 * (box.zmin() + box.zmax()));
    }
    constexpr std::size_t faces_of_a_slab = 100'000;
    std::sort(middles.begin(), middles.end());
    std::vector<double> limits = {-1e300};
    for (std::size_t i = faces_of_a_slab; i + faces_of_a_slab / 2 < middles.size(); i += faces_of_a_slab) limits.push_back(middles[i]);
    limits.push_back(1e300);
    std::set<std::pair<Mesh::Face_index, Mesh::Face_index>> all;
    parallel_for(limits.size() - 1, [&](std::size_t slab) {
        std::vector<Mesh::Face_index> inside;
        std::size_t i = 0;
        for (const auto face : mesh.faces()) {
            if (reach[i].second >= limits[slab] && reach[i].first <= limits[slab + 1]) inside.push_back(face);
            ++i;
        }
        std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> found;
        pmp::self_intersections(inside, mesh, std::back_inserter(found));
#pragma omp critical
        for (const auto& [first, second] : found) all.insert(std::minmax(first, second));
    });
    return all;
}

void add_places(SurfaceCheck& check, const Mesh& mesh, const std::set<std::pair<Mesh::Face_index, Mesh::Face_index>>& crossings) {
    for (const auto& [first, second] : crossings) {
        const Point& p = mesh.point(mesh.source(mesh.halfedge(first)));
        check.fault_places.emplace_back(p.x(), p.y(), p.z());
    }
}

// A surface with faulty edges: the rest of it may cross itself too, and all faults are wanted at once.
void add_crossings_elsewhere(SurfaceCheck& check, const TriangleSurface& surface) {
    std::set<std::array<double, 3>> faulty;
    for (const Vec3& place : check.fault_places) faulty.insert({place.x(), place.y(), place.z()});
    TriangleSurface rest{.points = surface.points, .triangles = {}};
    for (const auto& triangle : surface.triangles)
        if (std::none_of(triangle.begin(), triangle.end(),
                         [&](int corner) { return faulty.contains(surface.points[static_cast<std::size_t>(corner)]); }))
            rest.triangles.push_back(triangle);
    if (const auto mesh = mesh_of(rest)) add_places(check, *mesh, crossings_of(*mesh));
}

}  // namespace

SurfaceCheck check_surface(const TriangleSurface& surface) {
    SurfaceCheck check;
    check.low = Vec3::Constant(1e300);
    check.high = Vec3::Constant(-1e300);
    for (const auto& p : surface.points) {
        check.low = check.low.cwiseMin(Vec3(p[0], p[1], p[2]));
        check.high = check.high.cwiseMax(Vec3(p[0], p[1], p[2]));
    }
    check.fault = edge_fault(surface, check);
    if (!check.fault.empty()) return check;
    auto whole = mesh_of(surface);
    if (!whole) {
        check.fault = "the surface is not manifold: more than two triangles share an edge, or shells meet in a point";
        add_crossings_elsewhere(check, surface);
        return check;
    }
    Mesh& mesh = *whole;
    check.volume_m3 = pmp::volume(mesh);
    check.area_m2 = pmp::area(mesh);

    auto shell = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:shell").first;
    check.shells = static_cast<long>(pmp::connected_components(mesh, shell));
    std::vector<CGAL::Bbox_3> boxes(static_cast<std::size_t>(check.shells));
    for (const auto face : mesh.faces()) boxes[shell[face]] += pmp::face_bbox(face, mesh);
    for (const auto& box : boxes)
        check.largest_shell_diagonal_m = std::max(check.largest_shell_diagonal_m, Vec3(box.x_span(), box.y_span(), box.z_span()).norm());

    const auto crossings = crossings_of(mesh);
    check.self_intersecting = !crossings.empty();
    add_places(check, mesh, crossings);
    check.outward = check.volume_m3 > 0.0 && (check.self_intersecting || pmp::is_outward_oriented(mesh));
    if (check.volume_m3 <= 0.0) {
        check.fault = fmt::format("the surface is inside out: its volume is {:g} m3", check.volume_m3);
    } else if (check.self_intersecting) {
        const auto box = pmp::face_bbox(crossings.begin()->first, mesh);
        check.fault = fmt::format("the surface crosses itself: {} pairs of triangles, the first {}", crossings.size(),
                                  place_text({box.xmin(), box.ymin(), box.zmin()}));
    } else if (!pmp::does_bound_a_volume(mesh)) {
        check.fault = misplaced_shell(mesh, shell, check.shells);
    }
    return check;
}

void require_sound(const SurfaceCheck& check, const std::string& where) {
    if (check.fault.empty()) return;
    throw UserError("the surface does not bound a volume: " + check.fault,
                    {.where = where,
                     .allowed = "a closed surface with outward triangles that do not cross",
                     .fix = "repair it in the program that made it; nothing is repaired silently"});
}

void require_plausible_size(const SurfaceCheck& check, const Container& container, const std::string& where) {
    const Vec3 size = container.high() - container.low();
    const Vec3 extent = check.high - check.low;
    const double ratio = (extent.array() / size.array()).maxCoeff();
    const std::string numbers = fmt::format("the surface is {:.4g} x {:.4g} x {:.4g} m, the container {:.4g} x {:.4g} x {:.4g} m",
                                            extent.x(), extent.y(), extent.z(), size.x(), size.y(), size.z());
    if (ratio > 50.0)
        throw UserError("the surface is much larger than the container: " + numbers,
                        {.where = where, .fix = "it looks like millimetres: give --unit 0.001 (metres per unit)"});
    if (ratio < 0.002)
        throw UserError("the surface is much smaller than the container: " + numbers,
                        {.where = where, .fix = "check the unit with --unit (metres per unit)"});
    const Vec3 slack = 0.02 * size + (container.any_periodic() ? size : Vec3(Vec3::Zero()));
    if (((check.low - container.low() + slack).array() < 0.0).any() || ((container.high() + slack - check.high).array() < 0.0).any())
        throw UserError("the surface sticks out of the container: " + numbers,
                        {.where = fmt::format("{}: from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m", where, check.low.x(),
                                              check.low.y(), check.low.z(), check.high.x(), check.high.y(), check.high.z()),
                         .allowed = "cylinder: axis x = y = 0, floor z = 0; box: corner at the origin",
                         .fix = "move the surface, or give the right container and unit"});
}

}  // namespace porepack::converters
