#include "shapes/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace porepack::shapes {
namespace {

// Capsules touch with their axes, ends included, as edges do.
std::vector<ContactCurve> contact_curves(const PlacedShape& grain) {
    std::vector<ContactCurve> curves;
    if (grain.shape.body != nullptr) curves = grain.shape.body->contact_curves();
    for (const Capsule& capsule : grain.shape.capsules)
        curves.push_back({.kind = ContactCurve::Kind::edge, .a = capsule.a, .b = capsule.b, .radius = capsule.radius});
    for (ContactCurve& curve : curves) {
        curve.a = grain.to_world(curve.a);
        curve.b = curve.kind == ContactCurve::Kind::rim ? Vec3(grain.orientation * curve.b) : grain.to_world(curve.b);
    }
    return curves;
}

// A curve by a parameter from 0 to 1.
class Path {
public:
    explicit Path(const ContactCurve& curve) : curve_(curve) {
        if (closed()) {
            u_ = curve.rim_radius * curve.b.unitOrthogonal();
            v_ = curve.b.cross(u_);
        } else {
            u_ = curve.b - curve.a;
        }
    }
    [[nodiscard]] bool closed() const { return curve_.kind == ContactCurve::Kind::rim; }
    [[nodiscard]] double length() const {
        if (curve_.kind == ContactCurve::Kind::corner) return 0.0;
        return closed() ? 2.0 * std::numbers::pi * curve_.rim_radius : u_.norm();
    }
    [[nodiscard]] Vec3 at(double s) const {
        if (!closed()) return curve_.kind == ContactCurve::Kind::corner ? curve_.a : Vec3(curve_.a + s * u_);
        const double angle = 2.0 * std::numbers::pi * s;
        return curve_.a + std::cos(angle) * u_ + std::sin(angle) * v_;
    }

private:
    const ContactCurve& curve_;
    Vec3 u_ = Vec3::Zero(), v_ = Vec3::Zero();
};

struct Lowest {
    double value;
    double s = 0.0;      // on a closed curve it may lie below 0 or above 1
    bool found = false;  // somewhere below the limit
};

// The lowest value below `limit` of a function whose slope along the path is at most 1: from the value in the middle of a stretch follows a
// bound for all of it. Stretches of 1/64 and shorter are searched by golden sections.
template <typename F>
Lowest lowest_along(const Path& path, const F& f, double limit) {
    Lowest best{.value = limit};
    const double length = path.length();
    const auto visit = [&](double s) {
        const double value = f(path.at(s));
        if (value < best.value) best = {value, s, true};
        return value;
    };
    if (length == 0.0) {
        (void)visit(0.0);
        return best;
    }
    constexpr double shortest = 1.0 / 64.0;
    struct Stretch {
        double from, width, middle;
    };
    std::vector<Stretch> open, small;
    const int pieces = path.closed() ? 4 : 1;
    for (int i = 0; i < pieces; ++i) open.push_back({static_cast<double>(i) / pieces, 1.0 / pieces, 0.0});
    while (!open.empty()) {
        Stretch stretch = open.back();
        open.pop_back();
        stretch.middle = visit(stretch.from + 0.5 * stretch.width);
        if (stretch.middle - 0.5 * stretch.width * length >= best.value) continue;
        if (stretch.width <= shortest) {
            small.push_back(stretch);
            continue;
        }
        open.push_back({stretch.from, 0.5 * stretch.width, 0.0});
        open.push_back({stretch.from + 0.5 * stretch.width, 0.5 * stretch.width, 0.0});
    }
    std::sort(small.begin(), small.end(), [](const Stretch& one, const Stretch& other) { return one.middle < other.middle; });
    for (const Stretch& stretch : small) {
        if (stretch.middle - 0.5 * stretch.width * length >= best.value) continue;
        double low = stretch.from - stretch.width, high = stretch.from + 2.0 * stretch.width;
        if (!path.closed()) {
            low = std::max(0.0, low);
            high = std::min(1.0, high);
            (void)visit(low);
            (void)visit(high);
        }
        constexpr double golden = 0.6180339887498949;
        double a = high - golden * (high - low), b = low + golden * (high - low), at_a = visit(a), at_b = visit(b);
        for (int step = 0; step < 40; ++step) {
            if (at_a <= at_b) {
                high = b;
                b = a;
                at_b = at_a;
                a = high - golden * (high - low);
                at_a = visit(a);
            } else {
                low = a;
                a = b;
                at_a = at_b;
                b = low + golden * (high - low);
                at_b = visit(b);
            }
        }
    }
    return best;
}

}  // namespace

double signed_distance(const std::vector<Capsule>& capsules, const Vec3& point, Vec3& outward) {
    double nearest = 1e300;
    for (const Capsule& capsule : capsules) {
        const Vec3 away = point - closest_on_axis(capsule, point);
        const double length = away.norm();
        if (length - capsule.radius >= nearest) continue;
        nearest = length - capsule.radius;
        outward = length > 0.0 ? Vec3(away / length) : Vec3(Vec3::UnitZ());
    }
    return nearest;
}

double signed_distance(const PlacedShape& grain, const Vec3& point) {
    const Vec3 own = grain.to_shape(point);
    return grain.shape.body != nullptr ? grain.shape.body->distance(own) : signed_distance(grain.shape.capsules, own);
}

double signed_distance(const PlacedShape& grain, const Vec3& point, Vec3& outward) {
    const Vec3 own = grain.to_shape(point);
    const double away =
        grain.shape.body != nullptr ? grain.shape.body->distance(own, &outward) : signed_distance(grain.shape.capsules, own, outward);
    outward = grain.orientation * outward;
    return away;
}

Bounds bounds_of(const PlacedShape& grain) {
    Bounds bounds;
    if (grain.shape.body != nullptr)
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 along = grain.orientation.conjugate() * Vec3::Unit(axis);
            bounds.high[axis] = grain.position_m[axis] + grain.shape.body->support(along);
            bounds.low[axis] = grain.position_m[axis] - grain.shape.body->support(-along);
        }
    for (const Capsule& capsule : grain.shape.capsules) add(bounds, moved(capsule, grain.position_m, grain.orientation));
    return bounds;
}

std::vector<Ball> balls_of(const PlacedShape& grain) {
    constexpr int places = 16;
    std::vector<Ball> balls;
    for (const ContactCurve& curve : contact_curves(grain)) {
        if (curve.kind == ContactCurve::Kind::axis) continue;
        const Path path(curve);
        const int count = path.length() > 0.0 ? places : 1, last = path.closed() ? places : places - 1;
        for (int k = 0; k < count; ++k) balls.push_back({path.at(static_cast<double>(k) / std::max(1, last)), curve.radius});
    }
    return balls;
}

namespace {

// What reaches into a hole through the wall is in the middle of the wall too, around this point of the axis: in the direction of what is
// nearest, or another one.
template <typename F>
bool is_in_wall(const ContactCurve& axis, const Vec3& x, const Vec3& out_of_other, const F& distance) {
    constexpr int directions = 16;
    const double middle = 0.5 * (axis.radius + axis.hole_radius);
    const Vec3 along = (axis.b - axis.a).normalized(), u = along.unitOrthogonal(), v = along.cross(u);
    const Vec3 towards = out_of_other.dot(along) * along - out_of_other;
    if (towards.norm() > 0.1 && distance(x + middle * towards.normalized()) < 0.0) return true;
    for (int i = 0; i < directions; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / directions;
        if (distance(x + middle * (std::cos(angle) * u + std::sin(angle) * v)) < 0.0) return true;
    }
    return false;
}

}  // namespace

Nearest nearest(const PlacedShape& first, const PlacedShape& second, double beyond_m) {
    Nearest found{.gap_m = beyond_m};
    const auto search = [&](const PlacedShape& own, const PlacedShape& other, double side) {
        for (const ContactCurve& curve : contact_curves(own)) {
            const Path path(curve);
            const auto distance = [&](const Vec3& x) { return signed_distance(other, x); };
            const Lowest lowest = lowest_along(path, distance, found.gap_m + curve.radius);
            if (!lowest.found) continue;
            const Vec3 x = path.at(lowest.s);
            Vec3 out_of_other;
            (void)signed_distance(other, x, out_of_other);
            if (curve.kind == ContactCurve::Kind::axis) {
                const bool through_wall =
                    curve.hole_radius > 0.0 && lowest.value <= curve.hole_radius && is_in_wall(curve, x, out_of_other, distance);
                constexpr double at_end = 1e-6;
                if (!through_wall && (lowest.s < at_end || lowest.s > 1.0 - at_end || lowest.value <= curve.hole_radius)) continue;
                // Less deep below an end than below the round side.
                const double depth = through_wall ? 0.5 * (curve.radius - curve.hole_radius) : curve.radius - lowest.value;
                if (depth > std::min(lowest.s, 1.0 - lowest.s) * path.length() + own.shape.body->rounding()) continue;
            }
            found.gap_m = lowest.value - curve.radius;
            found.point = x - (curve.radius + 0.5 * found.gap_m) * out_of_other;
            found.normal = -side * out_of_other;
        }
    };
    search(first, second, 1.0);
    search(second, first, -1.0);
    return found;
}

double reach_beyond(const PlacedShape& grain, const std::function<double(const Vec3&)>& wall_distance) {
    double beyond = -1e300;
    for (const ContactCurve& curve : contact_curves(grain)) {
        if (curve.kind == ContactCurve::Kind::axis) continue;
        const Lowest lowest = lowest_along(Path(curve), wall_distance, curve.radius - beyond);
        if (lowest.found) beyond = curve.radius - lowest.value;
    }
    return beyond;
}

}  // namespace porepack::shapes
