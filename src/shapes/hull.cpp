// Convex hull of a union of capsules: the hull of their end spheres, exact.
// Its boundary consists of plane triangles tangent to three spheres, strips of cones tangent to two, and parts of the
// spheres. All three follow from the arcs of unit normals at which two spheres are the outermost together: such an arc is a
// strip, its ends are triangles, and the arcs around one sphere bound that sphere's part.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "shapes/shape.hpp"

namespace porepack::shapes {
namespace {

constexpr double full_turn = 2.0 * std::numbers::pi;

struct Sphere {
    Vec3 centre;
    double radius;
};

// Normals a cos(angle) e0 + ... at which spheres i and j are outermost together: n(phi) = e0 c + s (e1 cos phi + e2 sin phi),
// phi from low to high, with e0 the direction from i to j. Seen along e0 the arc runs anticlockwise.
struct Arc {
    std::size_t i, j;
    Vec3 e0, e1, e2;
    double c, s, low, high;
    [[nodiscard]] Vec3 normal(double phi) const { return c * e0 + s * (std::cos(phi) * e1 + std::sin(phi) * e2); }
    [[nodiscard]] Vec3 slope(double phi) const { return s * (std::cos(phi) * e2 - std::sin(phi) * e1); }
};

// Spheres not inside another one, each radius perturbed by less than 1e-9 of it: then no four spheres share a tangent plane,
// and no three on a line a tangent cone.
std::vector<Sphere> end_spheres(const std::vector<Capsule>& capsules) {
    std::vector<Sphere> all, kept;
    for (const auto& capsule : capsules) {
        all.push_back({capsule.a, capsule.radius});
        all.push_back({capsule.b, capsule.radius});
    }
    const auto holds = [](const Sphere& outer, const Sphere& inner) {
        return (outer.centre - inner.centre).norm() + inner.radius <= outer.radius * (1.0 + 1e-8);
    };
    for (std::size_t i = 0; i < all.size(); ++i) {
        bool inside = false;
        for (std::size_t j = 0; j < all.size() && !inside; ++j)
            inside = j != i && holds(all[j], all[i]) && (j < i || !holds(all[i], all[j]));
        if (!inside) kept.push_back(all[i]);
    }
    for (std::size_t i = 0; i < kept.size(); ++i) {
        // A fixed pseudo-random sequence: the same shape always gives the same numbers.
        const double scattered = 43758.5453 * std::sin(12.9898 * static_cast<double>(i + 1));
        kept[i].radius *= 1.0 - 1e-9 * (scattered - std::floor(scattered));
    }
    return kept;
}

// The part of the full circle of normals at which `i` and `j` are tangent to one cone and no other sphere lies further out.
void add_arcs(const std::vector<Sphere>& spheres, std::size_t i, std::size_t j, std::vector<Arc>& arcs) {
    const Vec3 between = spheres[j].centre - spheres[i].centre;
    const double distance = between.norm();
    Arc arc{.i = i, .j = j, .e0 = between / distance, .e1 = {}, .e2 = {}, .c = 0.0, .s = 0.0, .low = 0.0, .high = full_turn};
    arc.c = (spheres[i].radius - spheres[j].radius) / distance;
    if (std::abs(arc.c) >= 1.0) return;
    arc.s = std::sqrt(1.0 - arc.c * arc.c);
    arc.e1 = arc.e0.unitOrthogonal();
    arc.e2 = arc.e0.cross(arc.e1);
    std::vector<Interval> hidden;
    for (std::size_t m = 0; m < spheres.size(); ++m) {
        if (m == i || m == j) continue;
        // Sphere m lies further out where p cos phi + q sin phi > limit.
        // The support of sphere m in the direction n is centre . n + radius. Its difference to that of sphere i along the arc is a cosine
        // of phi.
        const Vec3 w = spheres[m].centre - spheres[i].centre;
        const double p = arc.s * w.dot(arc.e1), q = arc.s * w.dot(arc.e2);
        const double limit = spheres[i].radius - spheres[m].radius - arc.c * w.dot(arc.e0);
        const double size = std::hypot(p, q);
        if (size <= limit) continue;
        if (-size >= limit) return;
        const double half = std::acos(limit / size);
        double low = std::atan2(q, p) - half;
        if (low < 0.0) low += full_turn;
        const double high = low + 2.0 * half;
        hidden.push_back({low, std::min(high, full_turn)});
        if (high > full_turn) hidden.push_back({0.0, high - full_turn});
    }
    if (hidden.empty()) {
        arcs.push_back(arc);
        return;
    }
    std::sort(hidden.begin(), hidden.end(), [](const Interval& a, const Interval& b) { return a.low < b.low; });
    const bool passes_zero = hidden.front().low > 0.0;
    const double first = hidden.front().low;
    double at = passes_zero ? first : 0.0;
    for (const auto& part : hidden) {
        if (part.low > at) {
            arc.low = at;
            arc.high = part.low;
            arcs.push_back(arc);
        }
        at = std::max(at, part.high);
    }
    // The interval through phi = 0 is one arc.
    const double end = passes_zero ? full_turn + first : full_turn;
    if (at < end) {
        arc.low = at;
        arc.high = end;
        arcs.push_back(arc);
    }
}

// Integral over an arc, in pieces small enough for Gauss quadrature.
template <typename Value>
double integrate(const Arc& arc, const Value& value) {
    constexpr double node[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    constexpr double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const int pieces = 1 + static_cast<int>(8.0 * (arc.high - arc.low));
    const double half = 0.5 * (arc.high - arc.low) / pieces;
    double sum = 0.0;
    for (int k = 0; k < pieces; ++k) {
        const double middle = arc.low + (2 * k + 1) * half;
        for (int g = 0; g < 4; ++g) sum += weight[g] * half * (value(middle - node[g] * half) + value(middle + node[g] * half));
    }
    return sum;
}

}  // namespace

SurfaceSizes hull(const Shape& shape) {
    if (shape.body != nullptr) return shape.body->hull();
    const std::vector<Capsule>& capsules = shape.capsules;
    const Bounds bounds = bounds_of(capsules);
    const Vec3 about = 0.5 * (bounds.low + bounds.high);
    const double unit = 0.5 * (bounds.high - bounds.low).maxCoeff();
    std::vector<Sphere> spheres = end_spheres(capsules);
    for (auto& sphere : spheres) sphere = {(sphere.centre - about) / unit, sphere.radius / unit};
    // The volume is one third of the integral of the support function over the surface (divergence theorem for the field x / 3). The three
    // kinds of pieces are summed one after another: strips of cones, triangles, parts of spheres.
    double volume = 0.0, area = 0.0;
    const auto support = [&](std::size_t i, const Vec3& n) { return spheres[i].centre.dot(n) + spheres[i].radius; };

    std::vector<Arc> arcs;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = i + 1; j < spheres.size(); ++j) add_arcs(spheres, i, j, arcs);

    for (const auto& arc : arcs) {
        const Sphere &first = spheres[arc.i], &second = spheres[arc.j];
        const double length = arc.s * (second.centre - first.centre).norm();
        const double width = 0.5 * arc.s * (first.radius + second.radius);  // mean, per radian
        area += length * width * (arc.high - arc.low);
        volume += length * width * integrate(arc, [&](double phi) { return support(arc.i, arc.normal(phi)); }) / 3.0;
        if (arc.high - arc.low >= full_turn) continue;
        for (const double phi : {arc.low, arc.high}) {
            // Three arcs end at each triangle.
            const Vec3 n = arc.normal(phi);
            std::size_t third = arc.i;
            double maximum = -1e300;
            for (std::size_t m = 0; m < spheres.size(); ++m)
                if (m != arc.i && m != arc.j && support(m, n) > maximum) {
                    maximum = support(m, n);
                    third = m;
                }
            const auto touch = [&](std::size_t m) { return Vec3(spheres[m].centre + spheres[m].radius * n); };
            const double triangle = 0.5 * (touch(arc.j) - touch(arc.i)).cross(touch(third) - touch(arc.i)).norm();
            area += triangle / 3.0;
            volume += triangle * support(arc.i, n) / 9.0;
        }
    }

    // The part of the unit sphere of normals that belongs to each sphere, by Stokes' theorem along its arcs: the solid angle
    // with the potential that is singular at -pole, a direction outside the part.
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        double solid_angle = spheres.size() == 1 ? 2.0 * full_turn : 0.0;
        Vec3 mean = Vec3::Zero();  // integral of the normal
        Vec3 pole = Vec3::Zero();
        // The pole points away from the neighbour that covers the largest part of this sphere, so that -pole lies in the part that is
        // covered.
        double clearest = -1e300;
        for (std::size_t j = 0; j < spheres.size(); ++j) {
            if (j == i) continue;
            const Vec3 between = spheres[j].centre - spheres[i].centre;
            const double margin = (spheres[j].radius - spheres[i].radius) / between.norm();
            if (margin > clearest) {
                clearest = margin;
                pole = -between.normalized();
            }
        }
        for (const auto& arc : arcs) {
            if (arc.i != i && arc.j != i) continue;
            // The part lies on the right of the arc for the first sphere, on its left for the second.
            const double turn = arc.i == i ? -1.0 : 1.0;
            solid_angle += turn * integrate(arc, [&](double phi) {
                               const Vec3 n = arc.normal(phi);
                               return pole.dot(n.cross(arc.slope(phi))) / (1.0 + pole.dot(n));
                           });
            for (int axis = 0; axis < 3; ++axis)
                mean[axis] += turn * 0.5 * integrate(arc, [&](double phi) { return arc.normal(phi).cross(arc.slope(phi))[axis]; });
        }
        const double r = spheres[i].radius;
        area += r * r * solid_angle;
        volume += r * r * (spheres[i].centre.dot(mean) + r * solid_angle) / 3.0;
    }
    return {.volume_m3 = volume * unit * unit * unit, .surface_area_m2 = area * unit * unit};
}

}  // namespace porepack::shapes
