#include "converters/mesh_intersections.hpp"

#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include <array>
#include <iterator>

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;

std::optional<Mesh> boolean_of(Boolean operation, Mesh& first, Mesh& second) {
    // All three by one function, in the order of CGAL's enum: union, intersection, first - second, second - first.
    Mesh result;
    std::array<boost::optional<Mesh*>, 4> results;
    results[operation == Boolean::unite       ? pmp::Corefinement::UNION
            : operation == Boolean::intersect ? pmp::Corefinement::INTERSECTION
                                              : pmp::Corefinement::TM1_MINUS_TM2] = &result;
    const std::array<bool, 4> possible = pmp::corefine_and_compute_boolean_operations(first, second, results);
    for (std::size_t i = 0; i < 4; ++i)
        if (results[i] && !possible[i]) return std::nullopt;
    result.collect_garbage();
    return result;
}

void cut_along_intersection(Mesh& first, Mesh& second, EdgeMarks cut) {
    pmp::corefine(first, second, CGAL::parameters::default_values(), CGAL::parameters::edge_is_constrained_map(cut));
}

std::vector<FacePair> self_intersections(const Mesh& mesh) {
    std::vector<FacePair> pairs;
    pmp::self_intersections(mesh, std::back_inserter(pairs));
    return pairs;
}

std::vector<FacePair> self_intersections(const Mesh& mesh, const std::vector<Mesh::Face_index>& faces) {
    std::vector<FacePair> pairs;
    pmp::self_intersections(faces, mesh, std::back_inserter(pairs));
    return pairs;
}

void repair_self_intersections(Mesh& mesh, const std::vector<Mesh::Face_index>& faces) {
    pmp::experimental::remove_self_intersections(faces, mesh, CGAL::parameters::preserve_genus(false));
    mesh.collect_garbage();
}

}  // namespace porepack::converters
