#include "scans/shape_points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "packing/grains.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

// Evenly spread directions: a spiral on the sphere.
std::vector<Vec3> directions(int count) {
    std::vector<Vec3> found;
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - 2.0 * (i + 0.5) / count, r = std::sqrt(1.0 - z * z);
        found.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
    }
    return found;
}

// Distance from a point in the solid to the surface: the shortest way out, in many directions.
double depth_of(const Shape& shape, const Vec3& point) {
    double minimum = 1e300;
    std::vector<Interval> parts;
    for (const Vec3& direction : directions(200)) {
        parts.clear();
        for (const Capsule& capsule : shape.capsules)
            if (const auto part = line_interval(capsule, point, direction)) parts.push_back(*part);
        geometry::unite(parts);
        double way = 0.0;
        for (const Interval& part : parts)
            if (part.low <= 0.0 && part.high > 0.0) way = part.high;
        minimum = std::min(minimum, way);
    }
    return minimum;
}

bool inside(const std::vector<Capsule>& capsules, const Vec3& point, double tolerance) {
    return signed_distance(capsules, point) < tolerance;
}

// Points on a capsule about `step` apart: rings along its axis and on both caps.
void add_points(const Capsule& capsule, double step, std::vector<Vec3>& points) {
    const Vec3 axis = capsule.b - capsule.a;
    const double length = axis.norm(), r = capsule.radius;
    const Vec3 u = length > 0.0 ? Vec3(axis / length) : Vec3::UnitZ();
    const Vec3 v = u.unitOrthogonal(), w = u.cross(v);
    const auto ring = [&](const Vec3& centre, double radius) {
        const int count = std::max(1, static_cast<int>(std::lround(2.0 * std::numbers::pi * radius / step)));
        for (int i = 0; i < count; ++i) {
            const double angle = 2.0 * std::numbers::pi * (i + 0.5) / count;
            points.push_back(centre + radius * (std::cos(angle) * v + std::sin(angle) * w));
        }
    };
    const int along = static_cast<int>(std::lround(length / step)),
              cap = std::max(1, static_cast<int>(std::lround(0.5 * std::numbers::pi * r / step)));
    for (int i = 0; i < along; ++i) ring(capsule.a + (i + 0.5) / along * axis, r);
    for (int i = 0; i <= cap; ++i) {
        const double angle = 0.5 * std::numbers::pi * i / cap;
        ring(capsule.b + r * std::sin(angle) * u, r * std::cos(angle));
        ring(capsule.a - r * std::sin(angle) * u, r * std::cos(angle));
    }
}

}  // namespace

Pose moved_by(const Pose& pose, const Step& step) {
    Pose next = pose;
    next.position_m += step.head<3>();
    if (const double turn = step.tail<3>().norm(); turn > 0.0)
        next.orientation = (Quaternion(Eigen::AngleAxisd(turn, step.tail<3>() / turn)) * pose.orientation).normalized();
    return next;
}

std::vector<Capsule> placed(const std::vector<Capsule>& capsules, const Pose& pose) {
    std::vector<Capsule> all;
    all.reserve(capsules.size());
    for (const Capsule& capsule : capsules) all.push_back(moved(capsule, pose.position_m, pose.orientation));
    return all;
}

double largest_difference_m(const std::vector<Capsule>& first, const std::vector<Capsule>& second) {
    double largest = 0.0;
    for (const Capsule& one : first) {
        double minimum = 1e300;
        for (const Capsule& other : second)
            minimum = std::min({minimum, std::max((one.a - other.a).norm(), (one.b - other.b).norm()),
                                std::max((one.a - other.b).norm(), (one.b - other.a).norm())});
        largest = std::max(largest, minimum);
    }
    return largest;
}

namespace {

// Rotations about the origin that map the capsules onto themselves: those that map two ends onto two ends as far apart.
std::vector<Quaternion> symmetries_of(const std::vector<Capsule>& capsules, double tolerance) {
    // Two ends that are not parallel define a frame, and a rotation is known from the frames before and after it. So every pair of ends
    // with the same lengths and distance is a candidate, and a comparison of all capsules confirms it. The two ends of that frame span the
    // largest area with the first, which makes the frame accurate. Without two such ends (a sphere, a rod) only the identity is returned.
    std::vector<Vec3> ends;
    for (const Capsule& capsule : capsules)
        for (const Vec3& end : {capsule.a, capsule.b})
            if (end.norm() > tolerance) ends.push_back(end);
    if (ends.empty()) return {Quaternion::Identity()};
    const Vec3 first = ends[0];
    Vec3 second = Vec3::Zero();
    for (const Vec3& end : ends)
        if (first.cross(end).norm() > first.cross(second).norm()) second = end;
    if (first.cross(second).norm() < tolerance * first.norm()) return {Quaternion::Identity()};
    const auto frame = [](const Vec3& one, const Vec3& other) {
        Eigen::Matrix3d axes;
        axes.col(0) = one.normalized();
        axes.col(2) = one.cross(other).normalized();
        axes.col(1) = axes.col(2).cross(axes.col(0));
        return axes;
    };
    std::vector<Quaternion> found;
    for (const Vec3& one : ends)
        for (const Vec3& other : ends) {
            if (std::abs(one.norm() - first.norm()) > tolerance || std::abs(other.norm() - second.norm()) > tolerance ||
                (one - other).norm() - (first - second).norm() > tolerance || (first - second).norm() - (one - other).norm() > tolerance)
                continue;
            const Quaternion q(Eigen::Matrix3d(frame(one, other) * frame(first, second).transpose()));
            if (largest_difference_m(placed(capsules, {Vec3::Zero(), q}), capsules) > 3.0 * tolerance) continue;
            if (std::none_of(found.begin(), found.end(), [&](const Quaternion& known) { return std::abs(known.dot(q)) > 0.9999; }))
                found.push_back(q);
        }
    return found;
}

}  // namespace

ShapePoints points_of(const Shape& shape) {
    require_capsules(shape, "the fit of poses");
    ShapePoints found;
    found.capsules = shape.capsules;
    found.thinnest_radius_m = 0.5 * smallest_diameter(shape);
    Vec3 middle = Vec3::Zero();
    for (const Capsule& capsule : shape.capsules) {
        const int count = 1 + static_cast<int>(std::ceil((capsule.b - capsule.a).norm() / (0.7 * capsule.radius)));
        for (int i = 0; i < count; ++i)
            found.axis.push_back({capsule.a + (count > 1 ? i / (count - 1.0) : 0.0) * (capsule.b - capsule.a), capsule.radius});
        for (const Vec3& end : {capsule.a, capsule.b}) {
            found.reach_m = std::max(found.reach_m, end.norm() + capsule.radius);
            if (std::none_of(found.ends.begin(), found.ends.end(), [&](const Vec3& e) { return (e - end).norm() < 1e-3 * capsule.radius; }))
                found.ends.push_back(end);
        }
    }
    for (const Vec3& end : found.ends) middle += end / static_cast<double>(found.ends.size());
    // The deepest point; of equally deep ones that nearest to the middle, about which rotations reach least.
    std::vector<Vec3> places = {middle};
    for (const auto& [point, radius] : found.axis) places.push_back(point);
    std::vector<double> depths;
    double deepest = 0.0;
    for (const Vec3& place : places) deepest = std::max(deepest, depths.emplace_back(depth_of(shape, place)));
    double nearest = 1e300;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (depths[i] > 0.95 * deepest && (places[i] - middle).norm() < nearest) {
            nearest = (places[i] - middle).norm();
            found.anchor = places[i];
            found.anchor_depth_m = depths[i];
        }
    // One of the ends that the symmetry makes equal.
    std::vector<Capsule> about_anchor;
    for (const Capsule& capsule : shape.capsules)
        about_anchor.push_back({capsule.a - found.anchor, capsule.b - found.anchor, capsule.radius});
    const double tolerance = 0.01 * found.thinnest_radius_m;
    const std::vector<Quaternion> symmetries = symmetries_of(about_anchor, tolerance);
    for (const Vec3& end : found.ends)
        if (std::none_of(found.different_ends.begin(), found.different_ends.end(), [&](const Vec3& known) {
                return std::any_of(symmetries.begin(), symmetries.end(), [&](const Quaternion& q) {
                    return (q * (end - found.anchor) - (known - found.anchor)).norm() < 3.0 * tolerance;
                });
            }))
            found.different_ends.push_back(end);
    std::sort(found.axis.begin(), found.axis.end(), [&](const auto& one, const auto& other) {
        return (one.point - found.anchor).squaredNorm() > (other.point - found.anchor).squaredNorm();
    });
    std::vector<Vec3> all;
    for (const Capsule& capsule : shape.capsules) add_points(capsule, 0.5 * found.thinnest_radius_m, all);
    // Points that another capsule hides, or that lie in a filled cavity, are not on the outer surface of the grain.
    for (const Vec3& point : all)
        if (!inside(shape.capsules, point, -1e-3 * found.thinnest_radius_m) && !in_cavity(shape, point)) found.surface.push_back(point);
    found.volume_m3 = measure(shape, 1e-4, Effort::once).volume_m3;
    return found;
}

std::vector<Quaternion> rotations_of(const ShapePoints& shape, const Vec3& anchor, double step_m) {
    std::vector<Capsule> capsules;
    Vec3 farthest = Vec3::Zero();
    for (const Capsule& capsule : shape.capsules) {
        capsules.push_back({capsule.a - anchor, capsule.b - anchor, capsule.radius});
        for (const Vec3& end : {capsules.back().a, capsules.back().b})
            if (end.norm() > farthest.norm()) farthest = end;
    }
    // All ends near the anchor: no rotation moves them by a step.
    const double lever = farthest.norm();
    if (lever < 0.25 * step_m) return {Quaternion::Identity()};
    const double angle = std::min(std::numbers::pi, step_m / lever);
    double across = 0.0;
    for (const Capsule& capsule : capsules)
        for (const Vec3& end : {capsule.a, capsule.b}) across = std::max(across, farthest.cross(end).norm() / lever);
    std::vector<Quaternion> kept;
    if (across < 0.25 * step_m) {  // a rod: its axis in all directions
        // A cap of this half angle is the fraction (1 - cos angle) / 2 of the sphere; six directions per cap.
        const auto count = static_cast<int>(std::ceil(6.0 * 2.0 / (1.0 - std::cos(angle))));
        for (const Vec3& direction : directions(count)) kept.emplace_back(Quaternion::FromTwoVectors(farthest, direction));
        return kept;
    }
    // A ball of rotations by up to `angle` is the fraction (angle - sin angle) / pi of all; three times as many leave no gaps. Of those
    // that the symmetry makes equal, the one of the smallest angle.
    const std::vector<Quaternion> symmetries = symmetries_of(capsules, 0.01 * shape.thinnest_radius_m);
    const auto count = static_cast<long>(std::ceil(3.0 * std::numbers::pi / (angle - std::sin(angle))));
    // The constant of the spirals: the real root above 1 of psi^4 = psi + 4.
    constexpr double psi = 1.533751168755204288118041;
    for (long i = 0; i < count; ++i) {
        const double s = static_cast<double>(i) + 0.5, t = s / static_cast<double>(count), d = 2.0 * std::numbers::pi * s;
        const double r = std::sqrt(t), big = std::sqrt(1.0 - t), alpha = d / std::numbers::sqrt2, beta = d / psi;
        const Quaternion q(r * std::sin(alpha), r * std::cos(alpha), big * std::sin(beta), big * std::cos(beta));
        const bool smallest = std::none_of(symmetries.begin(), symmetries.end(), [&](const Quaternion& symmetry) {
            return std::abs((q * symmetry).w()) > std::abs(q.w()) + 1e-9;
        });
        if (smallest) kept.push_back(q);
    }
    return kept;
}

}  // namespace porepack::scans
