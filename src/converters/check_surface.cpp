#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/shape_predicates.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/boost/graph/Face_filtered_graph.h>
#include <CGAL/boost/graph/copy_face_graph.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "converters/mesh_intersections.hpp"
#include "converters/surface.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "vessels/config.hpp"

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

std::string place_text(const std::array<double, 3>& p) {
    return fmt::format("near ({:.6g}, {:.6g}, {:.6g}) m", p[0], p[1], p[2]);
}

// Triangles with the same three corners, whatever their order; their places are those of their edges.
std::string doubled_triangles(const TriangleSurface& surface, SurfaceCheck& check) {
    std::vector<std::array<int, 3>> sorted = surface.triangles;
    for (auto& corners : sorted) std::sort(corners.begin(), corners.end());
    std::sort(sorted.begin(), sorted.end());
    long doubled = 0;
    int first = 0;
    for (std::size_t t = 1; t < sorted.size(); ++t) {
        if (sorted[t] != sorted[t - 1]) continue;
        if (doubled++ == 0) first = sorted[t][0];
    }
    if (doubled == 0) return {};
    check.fix = "remove one of the two; bodies that touch in a face must be united (Boolean union) in the program that made them";
    return fmt::format("{} triangles lie on another with the same corners, the first {}", doubled,
                       place_text(surface.points[static_cast<std::size_t>(first)]));
}

// Every edge of a closed surface has exactly two triangles that run along it in opposite directions.
std::string edge_fault(const TriangleSurface& surface, SurfaceCheck& check) {
    // The sorted list brings the triangles of an edge together. Their directions sum up to zero if they are paired. An odd number of
    // triangles leaves the surface open; two in the same direction are twisted; an even number above two means that bodies meet in the
    // edge.
    std::vector<std::pair<std::pair<int, int>, int>> sides;  // of each edge, with its direction
    sides.reserve(3 * surface.triangles.size());
    for (const auto& triangle : surface.triangles)
        for (std::size_t c = 0; c < 3; ++c) {
            const int from = triangle[c], to = triangle[(c + 1) % 3];
            sides.emplace_back(std::minmax(from, to), from < to ? 1 : -1);
        }
    std::sort(sides.begin(), sides.end());
    struct Fault {
        long edges = 0;
        int first = 0;
    };
    Fault open, twisted, crowded;
    for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
        const auto edge = sides[i].first;
        int sum = 0;
        for (; end < sides.size() && sides[end].first == edge; ++end) sum += sides[end].second;
        const std::size_t count = end - i;
        if (count == 2 && sum == 0) continue;
        const auto& p = surface.points[static_cast<std::size_t>(edge.first)];
        check.fault_places.emplace_back(p[0], p[1], p[2]);
        Fault& fault = count % 2 == 1 ? open : count > 2 ? crowded : twisted;
        if (fault.edges++ == 0) fault.first = edge.first;
    }
    check.closed = open.edges == 0;
    const auto at = [&](const Fault& fault) { return place_text(surface.points[static_cast<std::size_t>(fault.first)]); };
    if (open.edges > 0) return fmt::format("the surface is open: {} edges have no neighbour, the first {}", open.edges, at(open));
    if (twisted.edges > 0)
        return fmt::format("neighbouring triangles have opposite orientations at {} edges, the first {}", twisted.edges, at(twisted));
    if (crowded.edges > 0) {
        check.fix = "move the bodies that touch there apart, or unite them (Boolean union) in the program that made them";
        return fmt::format("more than two triangles share an edge at {} edges, the first {}", crowded.edges, at(crowded));
    }
    return {};
}

// Shells that meet in a point: the triangles around it are not one ring.
std::string point_fault(const TriangleSurface& surface, SurfaceCheck& check) {
    std::vector<std::vector<std::pair<int, int>>> around(surface.points.size());  // of each point: the edges opposite to it
    for (const auto& triangle : surface.triangles)
        for (std::size_t c = 0; c < 3; ++c)
            around[static_cast<std::size_t>(triangle[c])].emplace_back(triangle[(c + 1) % 3], triangle[(c + 2) % 3]);
    long points = 0;
    std::size_t first = 0;
    for (std::size_t p = 0; p < around.size(); ++p) {
        auto& edges = around[p];
        std::sort(edges.begin(), edges.end());
        // The opposite edges of a regular point form one closed chain. It is followed from the first edge; if it closes before all edges
        // are used, several surfaces meet in the point.
        std::size_t length = edges.empty() ? 0 : 1;
        for (int at = edges.empty() ? 0 : edges.front().second; length < edges.size() && at != edges.front().first; ++length) {
            const auto next = std::lower_bound(edges.begin(), edges.end(), std::pair(at, -1));
            if (next == edges.end() || next->first != at) break;
            at = next->second;
        }
        if (length == edges.size()) continue;
        check.fault_places.emplace_back(surface.points[p][0], surface.points[p][1], surface.points[p][2]);
        if (points++ == 0) first = p;
    }
    if (points == 0) return {};
    check.fix = "move the bodies that touch there apart, or unite them (Boolean union) in the program that made them";
    return fmt::format("parts of the surface meet in {} points, the first {}", points, place_text(surface.points[first]));
}

// Triangles whose corners lie on a line: they are among those that cross their neighbours.
std::string flat_triangles(const Mesh& mesh, SurfaceCheck& check) {
    long flat = 0;
    Point first(0.0, 0.0, 0.0);
    for (const auto face : mesh.faces()) {
        if (!pmp::is_degenerate_triangle_face(face, mesh)) continue;
        if (flat++ == 0) first = mesh.point(mesh.source(mesh.halfedge(face)));
    }
    if (flat == 0) return {};
    check.fix = "remove triangles without area in the program that made them (Meshlab: Remove T-vertices; Blender: Degenerate dissolve)";
    return fmt::format("{} triangles have three corners on a line, the first {}", flat, place_text({first.x(), first.y(), first.z()}));
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
        // A shell inside an even number of others bounds solid, one inside an odd number a cavity.
        const bool outward = pmp::volume(part) > 0.0;
        if (outward == (depth % 2 == 0)) continue;
        return fmt::format("the shell {} is turned {} although {} shells enclose it", place_text({corner.x(), corner.y(), corner.z()}),
                           outward ? "outward" : "inward", depth);
    }
    return "the orientations of the shells contradict each other";
}

// Pairs of faces that cross each other. Slabs of the surface are searched in parallel: a face belongs to all slabs that it reaches.
// Faces that cross share a height, so both belong to the slab that contains it, and no pair is missed. A pair found in two slabs counts
// once in the set. The limits are quantiles of the faces' heights, which gives the slabs about equal numbers.
std::set<FacePair> crossings_of(const Mesh& mesh) {
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
    std::set<FacePair> all;
    parallel_for(limits.size() - 1, [&](std::size_t slab) {
        std::vector<Mesh::Face_index> inside;
        std::size_t i = 0;
        for (const auto face : mesh.faces()) {
            if (reach[i].second >= limits[slab] && reach[i].first <= limits[slab + 1]) inside.push_back(face);
            ++i;
        }
        const auto found = self_intersections(mesh, inside);
#pragma omp critical
        for (const auto& [first, second] : found) all.insert(std::minmax(first, second));
    });
    return all;
}

void add_places(SurfaceCheck& check, const Mesh& mesh, const std::set<FacePair>& crossings) {
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

// From the cheap checks to the expensive ones, and each only where those before it hold: edges, then points, which allow a mesh; crossings
// of faces; orientations of the shells, which have a meaning only without crossings.
SurfaceCheck check_surface(const TriangleSurface& surface) {
    SurfaceCheck check;
    check.low = Vec3::Constant(1e300);
    check.high = Vec3::Constant(-1e300);
    for (const auto& p : surface.points) {
        check.low = check.low.cwiseMin(Vec3(p[0], p[1], p[2]));
        check.high = check.high.cwiseMax(Vec3(p[0], p[1], p[2]));
    }
    check.fault = edge_fault(surface, check);
    std::optional<Mesh> whole;
    if (check.fault.empty() && !(whole = mesh_of(surface))) {
        check.fault = point_fault(surface, check);
        if (check.fault.empty()) check.fault = "its triangles do not form a surface";
    }
    if (!check.fault.empty()) {
        if (const std::string doubled = doubled_triangles(surface, check); !doubled.empty()) check.fault = doubled;
        if (check.closed) add_crossings_elsewhere(check, surface);
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
    check.fault = crossings.empty() ? std::string() : flat_triangles(mesh, check);
    check.outward = check.volume_m3 > 0.0 && (check.self_intersecting || pmp::is_outward_oriented(mesh));
    if (!check.fault.empty()) return check;
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
                     .fix = check.fix.empty() ? "repair it in the program that made it; nothing is repaired silently" : check.fix});
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
    // Grains press into a wall a little; in a periodic container they may reach into the next period.
    const Vec3 slack = 0.02 * size + (container.any_periodic() ? size : Vec3(Vec3::Zero()));
    if (((check.low - container.low() + slack).array() < 0.0).any() || ((container.high() + slack - check.high).array() < 0.0).any())
        throw UserError("the surface sticks out of the container: " + numbers,
                        {.where = fmt::format("{}: from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m", where, check.low.x(),
                                              check.low.y(), check.low.z(), check.high.x(), check.high.y(), check.high.z()),
                         .allowed = vessels::container_frames(),
                         .fix = "move the surface, or give the right container and unit"});
}

}  // namespace porepack::converters
