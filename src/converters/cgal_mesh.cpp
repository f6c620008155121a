#include <array>
#include <vector>

#include "converters/cgal_mesh.hpp"
#include "converters/uses.hpp"

#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;

std::optional<Mesh> mesh_of(const TriangleSurface& surface) {
    std::vector<Point> points;
    points.reserve(surface.points.size());
    for (const auto& p : surface.points) points.emplace_back(p[0], p[1], p[2]);
    std::vector<std::vector<std::size_t>> triangles;
    triangles.reserve(surface.triangles.size());
    for (const auto& t : surface.triangles)
        triangles.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])});
    if (!pmp::is_polygon_soup_a_polygon_mesh(triangles)) return std::nullopt;
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, triangles, mesh);
    return mesh;
}

void append(TriangleSurface& surface, const Mesh& mesh) {
    std::vector<int> index(mesh.num_vertices());
    for (const auto v : mesh.vertices()) {
        index[v.idx()] = static_cast<int>(surface.points.size());
        const Point& p = mesh.point(v);
        surface.points.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto face : mesh.faces()) {
        std::array<int, 3> triangle{};
        std::size_t c = 0;
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) triangle[c++] = index[v.idx()];
        surface.triangles.push_back(triangle);
    }
}

}  // namespace porepack::converters
