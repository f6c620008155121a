#include "shapes/triangle_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "core/joined_sets.hpp"
#include "geometry/triangle.hpp"

namespace porepack::shapes {
namespace {

constexpr std::size_t max_triangles = 5000;

// From `zero`, which is normal to `axis`.
double angle_about(const Vec3& axis, const Vec3& zero, const Vec3& direction) {
    return std::atan2(axis.dot(zero.cross(direction)), zero.dot(direction));
}

bool in_plane_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal) {
    return (b - a).cross(x - a).dot(normal) > 0.0 && (c - b).cross(x - b).dot(normal) > 0.0 && (a - c).cross(x - c).dot(normal) > 0.0;
}

}  // namespace

TriangleCore::TriangleCore(std::vector<Vec3> corners, std::vector<std::array<int, 3>> triangles)
    : corners_(std::move(corners)), triangles_(std::move(triangles)) {
    if (triangles_.size() > max_triangles)
        throw UserError(fmt::format("a grain has {} triangles", triangles_.size()), {.allowed = fmt::format("4 to {}", max_triangles)});
    for (const Vec3& corner : corners_) bounds_.add(corner, 0.0);
    extent_ = (bounds_.high - bounds_.low).norm();
    const auto at = [&](std::size_t t, int i) -> const Vec3& {
        return corners_[static_cast<std::size_t>(triangles_[t][static_cast<std::size_t>(i)])];
    };
    const Vec3 middle = 0.5 * (bounds_.low + bounds_.high);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const Vec3 twice_area = (at(t, 1) - at(t, 0)).cross(at(t, 2) - at(t, 0));
        if (!(twice_area.norm() > 1e-12 * extent_ * extent_))
            throw UserError(fmt::format("triangle {} has no area", t), {.fix = "remove it, and join its neighbours"});
        const Vec3 normal = twice_area.normalized();
        planes_.push_back({normal, normal.dot(at(t, 0))});
        volume_ += (at(t, 0) - middle).dot(twice_area) / 6.0;
    }
    if (!(volume_ > 0.0))
        throw UserError("the normals point inward", {.fix = "list the corners of each triangle counter-clockwise, seen from outside"});
    find_edges();
    require_one_part();
    require_no_crossing();
    find_cones();
    list_candidates();
    find_neck();
}

void TriangleCore::find_edges() {
    std::map<std::pair<int, int>, std::pair<std::size_t, std::size_t>> sides;  // triangle, side
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i)
            if (!sides.emplace(std::pair(triangles_[t][i], triangles_[t][(i + 1) % 3]), std::pair(t, i)).second)
                throw UserError(
                    fmt::format("two triangles have the side from corner {} to {}", triangles_[t][i], triangles_[t][(i + 1) % 3]),
                    {.fix = "each side belongs to two triangles, once in each direction"});
    edge_of_.resize(triangles_.size());
    corner_normals_.assign(corners_.size(), Vec3::Zero());
    for (const auto& [side, place] : sides) {
        const auto other = sides.find({side.second, side.first});
        if (other == sides.end())
            throw UserError(
                fmt::format("the surface is not closed: the side from corner {} to {} belongs to one triangle", side.first, side.second),
                {.fix = "close the hole"});
        if (side.first > side.second) continue;
        const auto [t, i] = place;
        const auto [u, j] = other->second;
        const Vec3 &a = corners_[static_cast<std::size_t>(side.first)], &b = corners_[static_cast<std::size_t>(side.second)];
        const Vec3 turn = planes_[t].normal.cross(planes_[u].normal);
        edge_of_[t][i] = edge_of_[u][j] = static_cast<int>(edges_.size());
        edges_.push_back({.a = side.first,
                          .b = side.second,
                          .triangles = {static_cast<int>(t), static_cast<int>(u)},
                          .normal_a = planes_[t].normal,
                          .normal_b = planes_[u].normal,
                          .convex = turn.dot((b - a).normalized()) > 1e-6});
        edge_normals_.push_back(planes_[t].normal + planes_[u].normal);
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto here = static_cast<std::size_t>(triangles_[t][i]);
            const Vec3 &x = corners_[here], &next = corners_[static_cast<std::size_t>(triangles_[t][(i + 1) % 3])],
                       &last = corners_[static_cast<std::size_t>(triangles_[t][(i + 2) % 3])];
            corner_normals_[here] += angle_between(next - x, last - x) * planes_[t].normal;
        }
}

// Triangles that hang together by their sides, and corners around which they do too.
void TriangleCore::require_one_part() const {
    JoinedSets parts(triangles_.size());
    for (const Edge& edge : edges_) parts.join(static_cast<std::size_t>(edge.triangles[0]), static_cast<std::size_t>(edge.triangles[1]));
    for (std::size_t t = 1; t < triangles_.size(); ++t)
        if (parts.root(t) != parts.root(0))
            throw UserError(fmt::format("the surface has several parts: triangles 0 and {} do not hang together", t),
                            {.fix = "one grain is one part"});
    // Around a corner, sides and triangles are as many, in one ring.
    std::vector<std::map<int, int>> next(corners_.size());
    for (const auto& triangle : triangles_)
        for (std::size_t i = 0; i < 3; ++i) next[static_cast<std::size_t>(triangle[i])][triangle[(i + 1) % 3]] = triangle[(i + 2) % 3];
    for (std::size_t c = 0; c < corners_.size(); ++c) {
        if (next[c].empty()) throw UserError(fmt::format("corner {} belongs to no triangle", c), {.fix = "remove it"});
        const int first = next[c].begin()->first;
        std::size_t ring = 1;
        for (int at = next[c].at(first); at != first && ring <= next[c].size(); at = next[c].at(at)) ++ring;
        if (ring != next[c].size())
            throw UserError(fmt::format("parts of the surface touch in corner {} only", c), {.fix = "separate them there"});
    }
}

// A side that passes through a triangle of which it has no corner.
void TriangleCore::require_no_crossing() const {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto& corners = triangles_[t];
        const Vec3 &a = corners_[static_cast<std::size_t>(corners[0])], &b = corners_[static_cast<std::size_t>(corners[1])],
                   &c = corners_[static_cast<std::size_t>(corners[2])];
        const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
        for (const Edge& edge : edges_) {
            if (std::any_of(corners.begin(), corners.end(), [&](int corner) { return corner == edge.a || corner == edge.b; })) continue;
            const Vec3 &from = corners_[static_cast<std::size_t>(edge.a)], &to = corners_[static_cast<std::size_t>(edge.b)];
            if ((from.cwiseMax(to).array() < low.array()).any() || (from.cwiseMin(to).array() > high.array()).any()) continue;
            const double start = planes_[t].normal.dot(from) - planes_[t].height, end = planes_[t].normal.dot(to) - planes_[t].height;
            if ((start > 0.0) == (end > 0.0)) continue;
            const Vec3 x = from + start / (start - end) * (to - from);
            if (in_plane_triangle(x, a, b, c, planes_[t].normal))
                throw UserError(
                    fmt::format("the surface crosses itself: the side from corner {} to {} passes through triangle {}", edge.a, edge.b, t),
                    {.fix = "repair it in the program it comes from"});
        }
    }
}

// The directions u with u.e <= 0 for all edges e from the corner. The polygon's corners are normal to two of them.
void TriangleCore::find_cones() {
    std::vector<std::vector<Vec3>> along(corners_.size());
    for (const Edge& edge : edges_) {
        const Vec3 e = (corners_[static_cast<std::size_t>(edge.b)] - corners_[static_cast<std::size_t>(edge.a)]).normalized();
        along[static_cast<std::size_t>(edge.a)].push_back(e);
        along[static_cast<std::size_t>(edge.b)].emplace_back(-e);
    }
    cones_.resize(corners_.size());
    for (std::size_t c = 0; c < corners_.size(); ++c) {
        Cone& cone = cones_[c];
        for (std::size_t i = 0; i < along[c].size(); ++i)
            for (std::size_t j = i + 1; j < along[c].size(); ++j) {
                const Vec3 cross = along[c][i].cross(along[c][j]);
                if (cross.norm() < 1e-9) continue;
                for (const double sign : {1.0, -1.0}) {
                    const Vec3 u = sign * cross.normalized();
                    const bool within = std::all_of(along[c].begin(), along[c].end(), [&](const Vec3& e) { return e.dot(u) <= 1e-12; });
                    const bool known =
                        std::any_of(cone.begin(), cone.end(), [&](const Vec3& one) { return (one - u).squaredNorm() < 1e-18; });
                    if (within && !known) cone.push_back(u);
                }
            }
        if (cone.size() < 3) {
            cone.clear();
            continue;
        }
        Vec3 middle = Vec3::Zero();
        for (const Vec3& u : cone) middle += u;
        middle.normalize();
        if (middle.dot(corner_normals_[c]) < 0.0) {  // of the solid's own points
            cone.clear();
            continue;
        }
        const Vec3 zero = middle.unitOrthogonal();
        std::sort(cone.begin(), cone.end(),
                  [&](const Vec3& a, const Vec3& b) { return angle_about(middle, zero, a) < angle_about(middle, zero, b); });
    }
}

void TriangleCore::try_triangle(std::size_t t, const Vec3& point, Nearest& nearest) const {
    const Plane& plane = planes_[t];
    const double above = plane.normal.dot(point) - plane.height;
    if (above * above >= nearest.square) return;
    const auto& corner = triangles_[t];
    const Vec3 &a = corners_[static_cast<std::size_t>(corner[0])], &b = corners_[static_cast<std::size_t>(corner[1])],
               &c = corners_[static_cast<std::size_t>(corner[2])];
    const auto take = [&](const Vec3& from, const Vec3& normal) {
        if (const double square = from.squaredNorm(); square < nearest.square) nearest = {square, from, &normal, t};
    };
    const auto take_corner = [&](std::size_t i, const Vec3& from) { take(from, corner_normals_[static_cast<std::size_t>(corner[i])]); };
    const auto take_edge = [&](std::size_t i, const Vec3& from) { take(from, edge_normals_[static_cast<std::size_t>(edge_of_[t][i])]); };
    geometry::nearest_of_triangle(a, b, c, point, take_corner, take_edge, [&] { take(above * plane.normal, plane.normal); });
}

double TriangleCore::distance_to(std::size_t triangle, const Vec3& point) const {
    Nearest nearest;
    try_triangle(triangle, point, nearest);
    return std::sqrt(nearest.square);
}

TriangleCore::Nearest TriangleCore::nearest(const Vec3& point) const {
    Nearest nearest{.normal = &planes_.front().normal};
    const Vec3 place = (point - low_) / cell_;
    if ((place.array() >= 0.0).all() && (place.array() < static_cast<double>(cells_)).all()) {
        const Vec3 corner = place.array().floor();
        const auto cell = (static_cast<std::size_t>(corner.z()) * cells_ + static_cast<std::size_t>(corner.y())) * cells_ +
                          static_cast<std::size_t>(corner.x());
        // No candidate can be nearer than its distance from the cell's middle less that of the point.
        const double off = cell_ * (place - corner - Vec3::Constant(0.5)).norm() * (1.0 + 1e-6);
        for (std::uint32_t n = lists_[cell]; n < lists_[cell + 1]; ++n) {
            const double least = static_cast<double>(candidates_[n].from_middle) - off;
            if (least > 0.0 && least * least >= nearest.square) break;
            try_triangle(candidates_[n].triangle, point, nearest);
        }
    } else {
        for (std::size_t t = 0; t < triangles_.size(); ++t) try_triangle(t, point, nearest);
    }
    return nearest;
}

double TriangleCore::distance(const Vec3& point, Vec3* outward, std::size_t* triangle) const {
    const Nearest nearest = this->nearest(point);
    if (triangle != nullptr) *triangle = nearest.triangle;
    const double away = std::sqrt(nearest.square);
    const bool inside = nearest.from.dot(*nearest.normal) < 0.0;
    if (outward != nullptr) {
        if (away > 1e-12 * extent_)
            *outward = (inside ? -1.0 : 1.0) / away * nearest.from;
        else
            *outward = nearest.normal->normalized();
    }
    return inside ? -away : away;
}

void TriangleCore::list_candidates() {
    const Vec3 size = bounds_.high - bounds_.low, middle = 0.5 * (bounds_.low + bounds_.high);
    cell_ = 1.5 * size.maxCoeff() / cells_;
    low_ = middle - Vec3::Constant(0.5 * cells_ * cell_);
    std::vector<std::uint16_t> all(triangles_.size());
    std::iota(all.begin(), all.end(), std::uint16_t{0});
    std::vector<std::vector<Candidate>> lists(static_cast<std::size_t>(cells_) * cells_ * cells_);
    add_lists(low_, cells_, {0, 0, 0}, all, lists);
    lists_.reserve(lists.size() + 1);
    for (const auto& list : lists) {
        lists_.push_back(static_cast<std::uint32_t>(candidates_.size()));
        candidates_.insert(candidates_.end(), list.begin(), list.end());
    }
    lists_.push_back(static_cast<std::uint32_t>(candidates_.size()));
}

// The lists of a cube with `cells` cells along each side. What is nearest to one of its points is farther from its middle than the triangle
// nearest to the middle by at most the cube's diagonal.
void TriangleCore::add_lists(const Vec3& low, int cells, const std::array<int, 3>& at, const std::vector<std::uint16_t>& from,
                             std::vector<std::vector<Candidate>>& lists) const {
    const double side = cells * cell_;
    const Vec3 middle = low + Vec3::Constant(0.5 * side);
    std::vector<double> away;
    double least = 1e300;
    for (const std::uint16_t t : from) {
        away.push_back(distance_to(t, middle));
        least = std::min(least, away.back());
    }
    std::vector<std::uint16_t> near;
    std::vector<Candidate> list;
    for (std::size_t n = 0; n < from.size(); ++n)
        if (away[n] <= least + std::sqrt(3.0) * side * (1.0 + 1e-9)) {
            near.push_back(from[n]);
            list.push_back({.from_middle = static_cast<float>(away[n] * (1.0 - 1e-6)), .triangle = from[n]});
        }
    if (cells == 1) {
        std::stable_sort(list.begin(), list.end(), [](const Candidate& a, const Candidate& b) { return a.from_middle < b.from_middle; });
        lists[(static_cast<std::size_t>(at[2]) * cells_ + static_cast<std::size_t>(at[1])) * cells_ + static_cast<std::size_t>(at[0])] =
            std::move(list);
        return;
    }
    for (int part = 0; part < 8; ++part) {
        const std::array<int, 3> step = {part & 1, part >> 1 & 1, part >> 2};
        const Vec3 corner = low + 0.5 * side * Vec3(step[0], step[1], step[2]);
        add_lists(corner, cells / 2, {at[0] + step[0] * cells / 2, at[1] + step[1] * cells / 2, at[2] + step[2] * cells / 2}, near, lists);
    }
}

// Cells are added from the deepest one on; where two parts meet that are both deeper than there, is a neck.
void TriangleCore::find_neck() {
    constexpr int n = 32;
    const Vec3 size = bounds_.high - bounds_.low;
    const double h = size.maxCoeff() / n;
    std::vector<std::pair<double, std::size_t>> cells;  // depth, place
    for (std::size_t i = 0; i < static_cast<std::size_t>(n) * n * n; ++i) {
        const Vec3 at(static_cast<double>(i % n) + 0.5, static_cast<double>(i / n % n) + 0.5, static_cast<double>(i / n / n) + 0.5);
        const Vec3 x = bounds_.low + h * at;
        if ((x.array() > bounds_.high.array()).any()) continue;
        if (const double depth = -distance(x, nullptr); depth > 0.0) cells.emplace_back(depth, i);
    }
    std::sort(cells.begin(), cells.end(),
              [](const auto& a, const auto& b) { return a.first > b.first || (a.first == b.first && a.second < b.second); });
    // What is thinner than the grid shows is at most half a cell.
    neck_radius_ = std::min(cells.empty() ? 0.25 * h : cells.front().first, 0.5 * size.minCoeff());
    JoinedSets parts(static_cast<std::size_t>(n) * n * n);
    std::vector<double> peak(static_cast<std::size_t>(n) * n * n, 0.0);  // 0: not yet flooded
    for (const auto& [depth, i] : cells) {
        peak[i] = depth;
        const std::array<std::size_t, 3> at = {i % n, i / n % n, i / n / n};
        std::size_t stride = 1;
        for (std::size_t axis = 0; axis < 3; ++axis, stride *= n)
            for (const bool up : {false, true}) {
                if (up ? at[axis] + 1 == n : at[axis] == 0) continue;
                const std::size_t other = up ? i + stride : i - stride;
                if (peak[other] == 0.0) continue;
                const std::size_t one = parts.root(i), two = parts.root(other);
                if (one == two) continue;
                if (std::min(peak[one], peak[two]) > 1.1 * depth + h) neck_radius_ = std::min(neck_radius_, depth);
                peak[one] >= peak[two] ? parts.join(two, one) : parts.join(one, two);
            }
    }
    const bool in_parts = std::any_of(cells.begin(), cells.end(), [&](const auto& cell) {
        return parts.root(cell.second) != parts.root(cells.front().second) && peak[parts.root(cell.second)] > h;
    });
    if (in_parts) neck_radius_ = std::min(neck_radius_, 0.25 * h);
}

}  // namespace porepack::shapes
