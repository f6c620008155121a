#include "shapes/capsule.hpp"

#include <algorithm>
#include <cmath>

#include "shapes/segments.hpp"

namespace porepack::shapes {

Vec3 closest_on_axis(const Capsule& capsule, const Vec3& point) {
    const Vec3 axis = capsule.b - capsule.a;
    const double length2 = axis.squaredNorm();
    if (length2 == 0.0) return capsule.a;
    return capsule.a + std::clamp((point - capsule.a).dot(axis) / length2, 0.0, 1.0) * axis;
}

double signed_distance(const Capsule& capsule, const Vec3& point) {
    return (point - closest_on_axis(capsule, point)).norm() - capsule.radius;
}

double signed_distance(const std::vector<Capsule>& capsules, const Vec3& point) {
    double minimum = 1e300;
    for (const auto& capsule : capsules) minimum = std::min(minimum, signed_distance(capsule, point));
    return minimum;
}

namespace {

std::optional<Interval> sphere_interval(const Vec3& centre, double radius, const Vec3& origin, const Vec3& direction) {
    const double middle = (centre - origin).dot(direction);
    const double half2 = radius * radius - (origin + middle * direction - centre).squaredNorm();
    if (half2 <= 0.0) return std::nullopt;
    return Interval{middle - std::sqrt(half2), middle + std::sqrt(half2)};
}

// The cylinder between the two end planes, without the caps.
std::optional<Interval> cylinder_interval(const Capsule& capsule, const Vec3& origin, const Vec3& direction) {
    const Vec3 axis = capsule.b - capsule.a;
    const double length = axis.norm();
    if (length == 0.0) return std::nullopt;
    const Vec3 u = axis / length;
    const Vec3 offset = origin - capsule.a;
    const double along_line = direction.dot(u);
    const double along_offset = offset.dot(u);
    const Vec3 across_line = direction - along_line * u;
    const Vec3 across_offset = offset - along_offset * u;
    const double A = across_line.squaredNorm();
    Interval inside{-1e300, 1e300};
    if (A < 1e-28) {
        if (across_offset.squaredNorm() >= capsule.radius * capsule.radius) return std::nullopt;
    } else {
        const double middle = -across_line.dot(across_offset) / A;
        const double half2 = (capsule.radius * capsule.radius - (across_offset + middle * across_line).squaredNorm()) / A;
        if (half2 <= 0.0) return std::nullopt;
        inside = {middle - std::sqrt(half2), middle + std::sqrt(half2)};
    }
    if (std::abs(along_line) < 1e-14) {
        if (along_offset < 0.0 || along_offset > length) return std::nullopt;
    } else {
        const double t0 = -along_offset / along_line;
        const double t1 = (length - along_offset) / along_line;
        inside.low = std::max(inside.low, std::min(t0, t1));
        inside.high = std::min(inside.high, std::max(t0, t1));
    }
    if (inside.low >= inside.high) return std::nullopt;
    return inside;
}

}  // namespace

std::optional<Interval> line_interval(const Capsule& capsule, const Vec3& origin, const Vec3& direction) {
    std::optional<Interval> whole;
    const auto join = [&](const std::optional<Interval>& part) {
        if (!part) return;
        whole = whole ? Interval{std::min(whole->low, part->low), std::max(whole->high, part->high)} : *part;
    };
    join(sphere_interval(capsule.a, capsule.radius, origin, direction));
    join(sphere_interval(capsule.b, capsule.radius, origin, direction));
    join(cylinder_interval(capsule, origin, direction));
    return whole;
}

double gap(const Capsule& first, const Capsule& second) {
    return closest_points({first.a, first.b - first.a}, {second.a, second.b - second.a}).distance - first.radius - second.radius;
}

void add(Bounds& bounds, const Capsule& capsule) {
    for (const Vec3& end : {capsule.a, capsule.b}) bounds.add(end, capsule.radius);
}

Bounds bounds_of(const std::vector<Capsule>& capsules) {
    Bounds bounds;
    for (const auto& capsule : capsules) add(bounds, capsule);
    return bounds;
}

Capsule moved(const Capsule& capsule, const Vec3& position, const Quaternion& orientation) {
    return {position + orientation * capsule.a, position + orientation * capsule.b, capsule.radius};
}

}  // namespace porepack::shapes
