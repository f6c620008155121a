// Compiled once and without fused multiply-adds (CMakeLists.txt): a pour is chaotic. Inline functions would be compiled in several
// libraries with different options, and the linker would take any of them.
#include "shapes/segments.hpp"

#include <algorithm>
#include <cmath>

namespace porepack::shapes {

ClosestPoints closest_points(const Segment& p, const Segment& q) {
    const Vec3 r = p.start - q.start;
    const double a = p.along.squaredNorm(), e = q.along.squaredNorm(), b = p.along.dot(q.along), c = p.along.dot(r), f = q.along.dot(r);
    const auto unit = [](double x) { return std::clamp(x, 0.0, 1.0); };
    const auto points = [&](double s, double t) -> ClosestPoints {
        const Vec3 x = p.start + s * p.along, y = q.start + t * q.along;
        return {x, y, (x - y).norm()};
    };
    if (!(a > 0.0)) return points(0.0, e > 0.0 ? unit(f / e) : 0.0);
    if (!(e > 0.0)) return points(unit(-c / a), 0.0);
    const double determinant = a * e - b * b;
    double s = determinant > 1e-16 * a * e ? unit((b * f - c * e) / determinant) : 0.0, t = (b * s + f) / e;
    if (t < 0.0 || t > 1.0) {
        t = unit(t);
        s = unit((b * t - c) / a);
    } else {
        s = unit((b * t - c) / a);
        t = unit((b * s + f) / e);
    }
    ClosestPoints best = points(s, t);
    if (determinant > 1e-6 * a * e) return best;
    // Nearly parallel: rounding in the determinant may have a large effect on s; then an end is nearer.
    for (const double end : {0.0, 1.0})
        for (const ClosestPoints& other : {points(end, unit((b * end + f) / e)), points(unit((b * end - c) / a), end)})
            if (other.distance < best.distance) best = other;
    return best;
}

Vec3 pressed_point(const Segment& p, const Segment& q, const ClosestPoints& closest, double overlap) {
    const double a = p.along.squaredNorm(), e = q.along.squaredNorm(), b = p.along.dot(q.along);
    if (!(a > 0.0) || !(e > 0.0)) return closest.on_first;
    constexpr double limit = 0.01;  // of the angle's squared sine
    const double sine2 = std::max(0.0, 1.0 - b * b / (a * e));
    if (sine2 >= limit) return closest.on_first;
    const double length = std::sqrt(a);
    const Vec3 along = p.along / length;
    const double at_start = (q.start - p.start).dot(along), at_end = at_start + q.along.dot(along);
    const double low = std::max(0.0, std::min(at_start, at_end)), high = std::min(length, std::max(at_start, at_end));
    if (low >= high) return closest.on_first;
    const double here = std::clamp((closest.on_first - p.start).dot(along), low, high);
    // At x from the closest point the distance has grown by x^2 sin^2/(2 distance).
    const double half = sine2 > 0.0 ? std::sqrt(2.0 * closest.distance * overlap / sine2) * (1.0 - sine2 / limit) : high - low;
    return p.start + 0.5 * (std::max(low, here - half) + std::min(high, here + half)) * along;
}

}  // namespace porepack::shapes
