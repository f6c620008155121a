// What CGAL computes from the intersections of meshes. One source instantiates it: the same templates take half a minute in each source
// that uses them.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "converters/cgal_mesh.hpp"

namespace porepack::converters {

enum class Boolean { unite, intersect, subtract };

/// The union, the intersection or the difference of two closed meshes, which are used up. None where CGAL cannot compute it.
[[nodiscard]] std::optional<Mesh> boolean_of(Boolean operation, Mesh& first, Mesh& second);

using EdgeMarks = Mesh::Property_map<Mesh::Edge_index, bool>;
/// Cuts both meshes along the curves in which they intersect; `cut` marks these edges of `second`.
void cut_along_intersection(Mesh& first, Mesh& second, EdgeMarks cut);

using FacePair = std::pair<Mesh::Face_index, Mesh::Face_index>;
/// Pairs of faces that intersect other than in a common edge or corner.
[[nodiscard]] std::vector<FacePair> self_intersections(const Mesh& mesh);
[[nodiscard]] std::vector<FacePair> self_intersections(const Mesh& mesh, const std::vector<Mesh::Face_index>& faces);
/// CGAL's local repair: replaces the triangles around the self-intersections of these faces, as far as it can.
void repair_self_intersections(Mesh& mesh, const std::vector<Mesh::Face_index>& faces);

}  // namespace porepack::converters
