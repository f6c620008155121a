#include "shapes/loops.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace porepack::shapes {

// Two triangles at the ends, of the radii r and f r, and others of f r: f sin(part) + (parts - 2) f^2 sin(part) / 2 = angle / 2.
double arc_factor(double angle, int parts) {
    const double sine = std::sin(angle / parts), square = 0.5 * (parts - 2) * sine;
    if (sine < 1e-9) return 1.0;
    return parts == 2 ? 0.5 * angle / sine : (std::sqrt(sine * sine + 2.0 * square * angle) - sine) / (2.0 * square);
}

DividedArc divided_arc(double radius, double angle, double deviation) {
    DividedArc arc{2, 1.0};
    for (;; ++arc.parts) {
        arc.factor = arc_factor(angle, arc.parts);
        if ((arc.factor - 1.0) * radius <= deviation || arc.parts >= 512) return arc;
    }
}

DividedArc divided_circle(double radius, double deviation) {
    DividedArc circle{8, 1.0};
    for (;; ++circle.parts) {
        const double part = 2.0 * std::numbers::pi / circle.parts;
        circle.factor = std::sqrt(part / std::sin(part));
        if ((circle.factor - 1.0) * radius <= deviation || circle.parts >= 512) return circle;
    }
}

std::vector<Facet> facets_between(const std::vector<Loop>& loops, bool closed) {
    std::vector<Facet> facets;
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        if (a != b && b != c && c != a) facets.push_back({a, b, c});
    };
    const std::size_t n = loops.front().size();
    const auto add_band = [&](const Loop& from, const Loop& to) {
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t next = (i + 1) % n;
            add(from[i], from[next], to[i]);
            add(from[next], to[next], to[i]);
        }
    };
    for (std::size_t k = 0; k + 1 < loops.size(); ++k) add_band(loops[k], loops[k + 1]);
    if (closed) {
        add_band(loops.back(), loops.front());
        return facets;
    }
    const Loop &first = loops.front(), &last = loops.back();
    const Vec3 below(0.0, 0.0, first[0].z()), above(0.0, 0.0, last[0].z());
    for (std::size_t i = 0; i < n; ++i) {
        add(below, first[(i + 1) % n], first[i]);
        add(last[i], last[(i + 1) % n], above);
    }
    return facets;
}

}  // namespace porepack::shapes
