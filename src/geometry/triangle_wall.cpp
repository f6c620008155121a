#include "geometry/triangle_wall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.hpp"
#include "core/joined_sets.hpp"
#include "geometry/triangle.hpp"

namespace porepack::inline geometry {
namespace {

Bounds box_of(const Vec3& a, const Vec3& b, const Vec3& c) {
    return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

// Throws unless each side of a triangle is that of one other, in the other direction.
void require_closed(const TriangleMesh& mesh, const std::string& where) {
    std::map<std::pair<int, int>, std::size_t> sides;
    const auto at = [&](int corner) {
        const Vec3& x = mesh.points_m[static_cast<std::size_t>(corner)];
        return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x.x(), x.y(), x.z());
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const int a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
            if (a < 0 || b < 0 || std::max(a, b) >= static_cast<int>(mesh.points_m.size()))
                throw UserError(fmt::format("triangle {} names a corner that is not there", t), {.where = where});
            if (!sides.emplace(std::pair(a, b), t).second)
                throw UserError(fmt::format("two triangles have the side from {} to {}", at(a), at(b)),
                                {.where = where, .fix = "each side belongs to two triangles, once in each direction"});
        }
    for (const auto& [side, t] : sides)
        if (!sides.contains({side.second, side.first}))
            throw UserError(
                fmt::format("the vessel's surface is open at the side from {} to {}", at(side.first), at(side.second)),
                {.where = where, .fix = "close it, the opening at the top included: the surface is that of the whole inner space"});
}

// An insert that touches no wall is a part of its own, whose volume is negative; the space around it has one part.
void require_one_space(const TriangleMesh& mesh, const std::string& where) {
    JoinedSets parts(mesh.points_m.size());
    for (const auto& triangle : mesh.triangles)
        for (const std::size_t i : {1, 0}) parts.join(static_cast<std::size_t>(triangle[i]), static_cast<std::size_t>(triangle[2]));
    std::map<std::size_t, double> volumes;
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto at = [&](int corner) -> const Vec3& { return mesh.points_m[static_cast<std::size_t>(corner)]; };
        volumes[parts.root(static_cast<std::size_t>(a))] += at(a).dot(at(b).cross(at(c))) / 6.0;
    }
    const auto spaces = std::count_if(volumes.begin(), volumes.end(), [](const auto& part) { return part.second > 0.0; });
    if (spaces > 1)
        throw UserError(fmt::format("the vessel's surface encloses {} separate spaces", spaces),
                        {.where = where, .fix = "one vessel per file; an insert's normals point into the insert"});
}

}  // namespace

TriangleWall::TriangleWall(TriangleMesh mesh, const std::string& where) : mesh_(std::move(mesh)) {
    if (mesh_.triangles.size() < 4) throw UserError("the vessel's surface has less than four triangles", {.where = where});
    require_closed(mesh_, where);
    for (const Vec3& point : mesh_.points_m) bounds_.add(point, 0.0);
    const double extent = (bounds_.high - bounds_.low).norm();
    double volume = 0.0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        const auto point = [&](std::size_t i) { return mesh_.points_m[static_cast<std::size_t>(mesh_.triangles[t][i])]; };
        const Vec3 twice_area = (point(1) - point(0)).cross(point(2) - point(0));
        if (!(twice_area.norm() > 1e-14 * extent * extent))
            throw UserError(fmt::format("triangle {} of the vessel's surface has no area", t),
                            {.where = where, .fix = "remove it, and join its neighbours"});
        volume += (point(0) - bounds_.low).dot(twice_area) / 6.0;
    }
    if (!(volume > 0.0))
        throw UserError("the normals of the vessel's surface point inward",
                        {.where = where, .fix = "turn them round: out of the inner space, into the wall"});
    require_one_space(mesh_, where);
    if (bounds_.low.z() != 0.0)
        throw UserError(fmt::format("the vessel's surface begins at z = {:.6g} m", bounds_.low.z()),
                        {.where = where, .allowed = "z = 0", .fix = "move it along z, and the grains with it"});
    find_ends(where);
    find_normals();
    std::vector<Bounds> boxes;
    for (const Triangle& t : sides_) boxes.push_back(box_of(corner(t, 0), corner(t, 1), corner(t, 2)));
    side_tree_ = BoxTree(boxes);
    boxes.clear();
    for (const Triangle& t : ends_) boxes.push_back(box_of(corner(t, 0), corner(t, 1), corner(t, 2)));
    end_tree_ = BoxTree(boxes);
    boxes.clear();
    for (const Rim& rim : rims_) boxes.push_back(box_of(rim.a, rim.b, rim.b));
    rim_tree_ = BoxTree(boxes);
}

// What is horizontal at the greatest height is the opening; at z = 0, the floor.
void TriangleWall::find_ends(const std::string& where) {
    const double slack = 1e-6 * (bounds_.high - bounds_.low).norm();
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        double low = 1e300, high = -1e300;
        for (const int corner : mesh_.triangles[t]) {
            low = std::min(low, mesh_.points_m[static_cast<std::size_t>(corner)].z());
            high = std::max(high, mesh_.points_m[static_cast<std::size_t>(corner)].z());
        }
        if (low > bounds_.high.z() - slack)
            opening_.push_back(t);
        else if (high < bounds_.low.z() + slack)
            floor_.push_back(t);
    }
    if (opening_.empty())
        throw UserError(fmt::format("the vessel has no opening: its surface has no horizontal face at its greatest height, z = {:.6g} m",
                                    bounds_.high.z()),
                        {.where = where, .fix = "end the vessel at its top by a horizontal face; the z axis points up"});
    points_ = mesh_.points_m;
    std::vector<bool> is_end(mesh_.triangles.size(), false);
    for (const auto* end : {&floor_, &opening_})
        for (const std::size_t t : *end) is_end[t] = true;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        if (is_end[t]) continue;
        sides_.push_back(mesh_.triangles[t]);
        const Triangle& side = sides_.back();
        side_area_ += 0.5 * (corner(side, 1) - corner(side, 0)).cross(corner(side, 2) - corner(side, 0)).norm();
    }
    const double far = 100.0 * (bounds_.high - bounds_.low).norm();
    lengthen(floor_, bounds_.low.z() - far);
    lengthen(opening_, bounds_.high.z() + far);
}

// The end moves to the height z, and sides from where it was.
void TriangleWall::lengthen(const std::vector<std::size_t>& end, double z) {
    std::map<int, int> moved;
    const auto copy = [&](int corner) {
        const auto [place, fresh] = moved.emplace(corner, static_cast<int>(points_.size()));
        if (fresh) {
            const Vec3& x = mesh_.points_m[static_cast<std::size_t>(corner)];
            points_.emplace_back(x.x(), x.y(), z);
        }
        return place->second;
    };
    std::map<std::pair<int, int>, bool> inner;
    for (const std::size_t t : end)
        for (std::size_t i = 0; i < 3; ++i) inner[{mesh_.triangles[t][i], mesh_.triangles[t][(i + 1) % 3]}] = true;
    for (const std::size_t t : end) {
        const Triangle& old = mesh_.triangles[t];
        ends_.push_back({copy(old[0]), copy(old[1]), copy(old[2])});
        for (std::size_t i = 0; i < 3; ++i) {
            const int a = old[i], b = old[(i + 1) % 3];
            if (inner.contains({b, a})) continue;
            sides_.push_back({a, b, copy(b)});
            sides_.push_back({a, copy(b), copy(a)});
        }
    }
}

void TriangleWall::find_normals() {
    std::map<std::pair<int, int>, std::size_t> side_of;
    corner_normals_.assign(points_.size(), Vec3::Zero());
    for (std::size_t t = 0; t < sides_.size(); ++t) {
        const Triangle& side = sides_[t];
        normals_.push_back((corner(side, 1) - corner(side, 0)).cross(corner(side, 2) - corner(side, 0)).normalized());
        for (std::size_t i = 0; i < 3; ++i) {
            side_of[{side[i], side[(i + 1) % 3]}] = t;
            const Vec3 &x = corner(side, i), &next = corner(side, (i + 1) % 3), &last = corner(side, (i + 2) % 3);
            corner_normals_[static_cast<std::size_t>(side[i])] += angle_between(next - x, last - x) * normals_[t];
        }
    }
    edge_normals_.resize(sides_.size());
    for (const auto& [edge, t] : side_of) {
        const auto other = side_of.find({edge.second, edge.first});
        const std::size_t u = other == side_of.end() ? t : other->second;  // at the far ends there is none
        for (std::size_t i = 0; i < 3; ++i)
            if (sides_[t][i] == edge.first) edge_normals_[t][i] = normals_[t] + normals_[u];
        if (edge.first > edge.second) continue;
        const Vec3 &a = points_[static_cast<std::size_t>(edge.first)], &b = points_[static_cast<std::size_t>(edge.second)];
        if (normals_[t].cross(normals_[u]).dot((b - a).normalized()) < -1e-6) rims_.push_back({a, b});
    }
}

double TriangleWall::volume_between(double z0, double z1) const {
    double volume = 0.0;
    for (const auto* part : {&sides_, &ends_})
        for (const Triangle& t : *part) volume += geometry::volume_between(corner(t, 0), corner(t, 1), corner(t, 2), z0, z1);
    return volume;
}

struct TriangleWall::Nearest {
    double square = 1e300;
    std::size_t side = 0;
    Vec3 from = Vec3::Zero();  // from there to the point
    const Vec3* normal = nullptr;
};

// Of two sides that are as near, that with the lower number: the order of the search does not matter.
void TriangleWall::try_side(std::size_t t, const Vec3& point, Nearest& nearest) const {
    const Triangle& side = sides_[t];
    const double above = normals_[t].dot(point - corner(side, 0));
    if (above * above > nearest.square) return;
    const auto take = [&](const Vec3& away, const Vec3& outward) {
        const double here = away.squaredNorm();
        if (here < nearest.square || (here == nearest.square && t < nearest.side)) nearest = {here, t, away, &outward};
    };
    nearest_of_triangle(
        corner(side, 0), corner(side, 1), corner(side, 2), point,
        [&](std::size_t i, const Vec3& away) { take(away, corner_normals_[static_cast<std::size_t>(side[i])]); },
        [&](std::size_t i, const Vec3& away) { take(away, edge_normals_[t][i]); }, [&] { take(above * normals_[t], normals_[t]); });
}

double TriangleWall::signed_distance(const Nearest& nearest, Vec3* inward) const {
    const double away = std::sqrt(nearest.square);
    const bool inside = nearest.from.dot(*nearest.normal) <= 0.0;
    if (inward != nullptr)
        *inward = away > 1e-12 * (bounds_.high - bounds_.low).norm() ? Vec3((inside ? 1.0 : -1.0) / away * nearest.from)
                                                                     : Vec3(-nearest.normal->normalized());
    return inside ? away : -away;
}

double TriangleWall::distance(const Vec3& point, Vec3* inward) const {
    Nearest nearest{.normal = &normals_.front()};
    side_tree_.search([&](const Bounds& box) { return square_from(box, point); }, [&] { return nearest.square; },
                      [&](std::size_t t) { try_side(t, point, nearest); });
    return signed_distance(nearest, inward);
}

double TriangleWall::distance(const Vec3& point, const std::vector<std::uint32_t>& sides, Vec3* inward) const {
    Nearest nearest{.normal = &normals_.front()};
    for (const std::uint32_t t : sides) try_side(t, point, nearest);
    return signed_distance(nearest, inward);
}

void TriangleWall::sides_near(const Vec3& point, double reach, std::vector<std::uint32_t>& found) const {
    found.clear();
    side_tree_.search([&](const Bounds& box) { return square_from(box, point); }, [&] { return reach * reach; },
                      [&](std::size_t t) {
                          Nearest nearest;
                          try_side(t, point, nearest);
                          if (nearest.square <= reach * reach) found.push_back(static_cast<std::uint32_t>(t));
                      });
    std::sort(found.begin(), found.end());
}

// At one of its ends, or above a rim.
double TriangleWall::least_distance(const Vec3& a, const Vec3& b) const {
    double least = std::min(distance(a), distance(b));
    if (least <= 0.0 || rims_.empty()) return least;
    if (first_hit(a, b - a)) return -1e-12 * (bounds_.high - bounds_.low).norm();
    const Vec3 d = b - a;
    rim_tree_.search(
        [&](const Bounds& box) {
            return meet(box, {a.cwiseMin(b).array() - least, a.cwiseMax(b).array() + least}) ? 0.0 : 1.0;
        },
        [] { return 0.5; },
        [&](std::size_t n) {
            // Of two lines; beyond its ends a segment's nearest point is an end (Ericson, 5.1.9).
            const Vec3 e = rims_[n].b - rims_[n].a, r = a - rims_[n].a;
            const double dd = d.squaredNorm(), ee = e.squaredNorm(), de = d.dot(e), er = e.dot(r), dr = d.dot(r),
                         crossed = dd * ee - de * de;
            double s = crossed > 1e-14 * dd * ee ? std::clamp((de * er - dr * ee) / crossed, 0.0, 1.0) : 0.0;
            double t = std::clamp((de * s + er) / ee, 0.0, 1.0);
            if (dd > 0.0) s = std::clamp((de * t - dr) / dd, 0.0, 1.0);
            t = std::clamp((de * s + er) / ee, 0.0, 1.0);
            least = std::min(least, (r + s * d - t * e).norm());
        });
    return least;
}

std::optional<double> TriangleWall::first_hit(const Vec3& from, const Vec3& step) const {
    double first = 2.0;
    const Bounds around{from.cwiseMin(from + step), from.cwiseMax(from + step)};
    // Out of the inner space means against the normals of the wall, which is on the other side: its triangles are turned round.
    side_tree_.search([&](const Bounds& box) { return meet(box, around) ? 0.0 : 1.0; }, [] { return 0.5; },
                      [&](std::size_t t) {
                          const Triangle& side = sides_[t];
                          if (const auto hit = crossing_from_outside(corner(side, 0), corner(side, 2), corner(side, 1), from, step))
                              first = std::min(first, *hit);
                      });
    return first <= 1.0 ? std::optional(first) : std::nullopt;
}

void TriangleWall::column(double x, double y, std::vector<Interval>& parts) const {
    parts.clear();
    if (x < bounds_.low.x() || x > bounds_.high.x() || y < bounds_.low.y() || y > bounds_.high.y()) return;
    thread_local std::vector<LineCrossing> crossings;
    constexpr double endless = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < 8; ++attempt) {
        crossings.clear();
        const auto [px, py] = line_nearby(x, y, (bounds_.high - bounds_.low).norm(), attempt);
        const auto key = [&, px = px, py = py](const Bounds& box) {
            return px >= box.low.x() && px <= box.high.x() && py >= box.low.y() && py <= box.high.y() ? 0.0 : 1.0;
        };
        const auto collect = [&, px = px, py = py](const std::vector<Triangle>& triangles, bool at_ends) {
            return [&, at_ends, px, py](std::size_t n) {
                auto crossing = line_crossing(corner(triangles[n], 0), corner(triangles[n], 1), corner(triangles[n], 2), px, py);
                if (!crossing) return;
                if (at_ends) crossing->z = crossing->step > 0 ? -endless : endless;
                crossings.push_back(*crossing);
            };
        };
        side_tree_.search(
            key, [] { return 0.5; }, collect(sides_, false));
        end_tree_.search(
            key, [] { return 0.5; }, collect(ends_, true));
        int sum = 0;
        for (const LineCrossing& crossing : crossings) sum += crossing.step;
        if (sum == 0) break;
    }
    parts_between(crossings, parts);
}

TriangleMesh TriangleWall::sides(double z0, double z1) const {
    TriangleMesh part{points_, {}};
    for (Vec3& point : part.points_m) point.z() = std::clamp(point.z(), std::min(z0, bounds_.low.z()), std::max(z1, bounds_.high.z()));
    const auto height = [&](int corner) { return part.points_m[static_cast<std::size_t>(corner)].z(); };
    const auto is_flat = [&](const Triangle& t, double z) { return height(t[0]) == z && height(t[1]) == z && height(t[2]) == z; };
    for (const Triangle& side : sides_)  // none that lies in an end that is not lengthened
        if (!is_flat(side, bounds_.low.z()) && !is_flat(side, bounds_.high.z())) part.triangles.push_back(side);
    return part;
}

}  // namespace porepack::inline geometry
