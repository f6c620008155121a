// One triangle, or one of a closed surface whose corners are counter-clockwise, seen from outside.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "geometry/vector.hpp"

namespace porepack::inline geometry {

/// The nearest point of a triangle, by the region in which the point's foot lies (Ericson, Real-Time Collision Detection, 5.1.5). Calls
/// one of corner(i, from), side(i, from) and face(), with the vector `from` there to the point; side i leads from corner i to the next.
template <typename Corner, typename Side, typename Face>
void nearest_of_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& point, const Corner& corner, const Side& side,
                         const Face& face) {
    const Vec3 ab = b - a, ac = c - a, ap = point - a;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0.0 && d2 <= 0.0) return corner(0, ap);
    const Vec3 bp = point - b;
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0.0 && d4 <= d3) return corner(1, bp);
    if (const double vc = d1 * d4 - d3 * d2; vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return side(0, ap - d1 / (d1 - d3) * ab);
    const Vec3 cp = point - c;
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0.0 && d5 <= d6) return corner(2, cp);
    if (const double vb = d5 * d2 - d1 * d6; vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return side(2, ap - d2 / (d2 - d6) * ac);
    if (const double va = d3 * d6 - d5 * d4; va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
        return side(1, bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
    face();
}

/// Fraction of the segment from `from` to `from + step` at which it crosses the triangle from outside (Moller & Trumbore 1997). A hit on a
/// side is not missed by both of its triangles.
[[nodiscard]] inline std::optional<double> crossing_from_outside(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& from,
                                                                 const Vec3& step) {
    const Vec3 e1 = b - a, e2 = c - a;
    const Vec3 p = step.cross(e2);
    const double determinant = e1.dot(p);
    if (determinant <= 0.0) return std::nullopt;
    const Vec3 s = from - a;
    const Vec3 q = s.cross(e1);
    const double u = s.dot(p) / determinant, v = step.dot(q) / determinant, at = e2.dot(q) / determinant;
    constexpr double slack = 1e-9;
    if (u < -slack || v < -slack || u + v > 1.0 + slack || at < -slack || at > 1.0) return std::nullopt;
    return std::max(0.0, at);
}

/// Where a vertical line crosses a surface.
struct LineCrossing {
    double z;
    int step;  ///< +1 into the body, going up
};
/// Of a triangle with the line at (x, y). Twice the signed areas of the three triangles that the line makes with the sides, seen from
/// above, have equal signs if the line passes inside, and are the weights of the corners' heights.
[[nodiscard]] inline std::optional<LineCrossing> line_crossing(const Vec3& a, const Vec3& b, const Vec3& c, double x, double y) {
    const auto side = [&](const Vec3& p, const Vec3& q) { return (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x()); };
    const double u = side(b, c), v = side(c, a), w = side(a, b);
    const double area = u + v + w;
    if (area == 0.0 || ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0))) return std::nullopt;
    return LineCrossing{(u * a.z() + v * b.z() + w * c.z()) / area, area > 0.0 ? -1 : 1};
}

/// The parts of a line inside a body, given its crossings, which are sorted; `parts` is empty before. Where shells overlap, the depth
/// exceeds 1: a part ends where it returns to 0.
inline void parts_between(std::vector<LineCrossing>& crossings, std::vector<core::Interval>& parts) {
    std::sort(crossings.begin(), crossings.end(), [](const auto& p, const auto& q) { return p.z < q.z; });
    int depth = 0;
    for (const LineCrossing& crossing : crossings) {
        if (depth == 0 && crossing.step > 0) parts.push_back({crossing.z, crossing.z});
        depth += crossing.step;
        if (depth == 0 && !parts.empty()) parts.back().high = crossing.z;
    }
}

/// Of a line through a side or a corner, which counts twice or not at all, the crossings of a line at a tiny distance: `attempt` is 0 to 7.
[[nodiscard]] inline std::array<double, 2> line_nearby(double x, double y, double extent, int attempt) {
    return {x + (1.13e-9 + 2.7e-9 * attempt) * extent, y + (0.71e-9 - 1.9e-9 * attempt) * extent};
}

/// The part of a triangle's volume above the plane z = 0 that lies between two heights. The sum over a closed surface is the body's volume
/// there, by Gauss' theorem with the field (0, 0, min(max(z, z0), z1)).
[[nodiscard]] inline double volume_between(const Vec3& a, const Vec3& b, const Vec3& c, double z0, double z1) {
    // The mean of max(0, z - level) over the triangle.
    const auto mean_above = [&](double level) {
        std::array<double, 3> h = {a.z() - level, b.z() - level, c.z() - level};
        std::sort(h.begin(), h.end());
        const double mean = (h[0] + h[1] + h[2]) / 3.0;
        if (h[0] >= 0.0) return mean;
        if (h[2] <= 0.0) return 0.0;
        if (h[1] <= 0.0) return h[2] * h[2] * h[2] / (3.0 * (h[2] - h[0]) * (h[2] - h[1]));
        return mean - h[0] * h[0] * h[0] / (3.0 * (h[1] - h[0]) * (h[2] - h[0]));
    };
    const double area = 0.5 * (b - a).cross(c - a).z();  // seen from above
    return area * (mean_above(z0) - mean_above(z1));
}

}  // namespace porepack::inline geometry
