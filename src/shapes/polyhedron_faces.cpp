#include "shapes/polyhedron_faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "core/error.hpp"

namespace porepack::shapes {

// The depth below the nearest face has one maximum, which is searched along one axis after another.
Vec3 middle_of_largest_ball(const std::vector<Face>& faces, const std::vector<Vec3>& corners) {
    const auto depth_at = [&](const Vec3& x) {
        double depth = 1e300;
        for (const Face& face : faces) depth = std::min(depth, face.height - face.normal.dot(x));
        return depth;
    };
    Vec3 low = corners.front(), high = low, mean = Vec3::Zero(), x = mean;
    for (const Vec3& corner : corners) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
        mean += corner / static_cast<double>(corners.size());
    }
    const std::function<double(int)> deepest_from = [&](int axis) {
        if (axis == 3) return depth_at(x);
        const auto negative = [&](double place) {
            x[axis] = place;
            return -deepest_from(axis + 1);
        };
        constexpr int bits = 20;
        return -negative(boost::math::tools::brent_find_minima(negative, low[axis], high[axis], bits).first);
    };
    constexpr double as_deep = 1.0 + 1e-4;
    return deepest_from(0) > as_deep * depth_at(mean) ? x : mean;
}

// Newell's normal, which needs no good choice of three corners.
Face plane_face(const std::vector<Vec3>& corners, const std::vector<int>& list, double size) {
    const auto at = [&](std::size_t i) -> const Vec3& { return corners[static_cast<std::size_t>(list[i % list.size()])]; };
    Vec3 normal = Vec3::Zero();
    for (std::size_t i = 0; i < list.size(); ++i) normal += at(i).cross(at(i + 1));
    if (list.size() < 3 || normal.norm() <= 1e-12 * size * size)
        throw UserError("a face of the polyhedron has no area", {.fix = "three corners or more, not on one line"});
    Face face{.corners = list, .normal = normal.normalized(), .height = 0.0, .outwards = {}, .edges = {}};
    for (std::size_t i = 0; i < list.size(); ++i) face.height += face.normal.dot(at(i)) / static_cast<double>(list.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (std::abs(face.normal.dot(at(i)) - face.height) > 1e-9 * size)
            throw UserError("a face of the polyhedron is not flat", {.allowed = "corners within 1e-9 of its size from one plane"});
        face.outwards.push_back((at(i + 1) - at(i)).cross(face.normal).normalized());
        for (std::size_t j = 0; j < list.size(); ++j)
            if (face.outwards.back().dot(at(j) - at(i)) > 1e-9 * size)
                throw UserError("a face of the polyhedron is not convex", {.fix = "divide it into convex polygons"});
    }
    return face;
}

namespace {

// Of the face in which it is a side, and of the other, in which it runs the other way.
Edge edge_between(const std::pair<int, int>& side, const std::array<std::size_t, 2>& of, const std::vector<Face>& faces) {
    const auto out_of = [](const Face& face, int from) {
        const auto place = std::find(face.corners.begin(), face.corners.end(), from) - face.corners.begin();
        return face.outwards[static_cast<std::size_t>(place)];
    };
    return {.a = side.first,
            .b = side.second,
            .faces = of,
            .normal_a = faces[of[0]].normal,
            .normal_b = faces[of[1]].normal,
            .out_a = out_of(faces[of[0]], side.first),
            .out_b = out_of(faces[of[1]], side.second)};
}

}  // namespace

std::vector<Edge> edges_of(const std::vector<Face>& faces) {
    std::map<std::pair<int, int>, std::size_t> sides;
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t i = 0; i < faces[f].corners.size(); ++i)
            if (!sides.emplace(std::pair(faces[f].corners[i], faces[f].corners[(i + 1) % faces[f].corners.size()]), f).second)
                throw UserError("the polyhedron is not closed, or a face has the wrong direction",
                                {.fix = "list the corners of each face counter-clockwise, seen from outside"});
    std::vector<Edge> edges;
    for (const auto& [side, face] : sides) {
        const auto other = sides.find({side.second, side.first});
        if (other == sides.end())
            throw UserError(
                fmt::format("the polyhedron is not closed: the edge from corner {} to {} has one face", side.first, side.second),
                {.fix = "list all faces, their corners counter-clockwise, seen from outside"});
        if (side.first < side.second) edges.push_back(edge_between(side, {face, other->second}, faces));
    }
    return edges;
}

}  // namespace porepack::shapes
