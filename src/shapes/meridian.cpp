#include "shapes/meridian.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace porepack::shapes {
namespace {

constexpr double right_angle = std::numbers::pi / 2.0;
// Two surfaces nearer than this fraction of the radius coincide.
constexpr double tie = 1e-13;
constexpr std::uint32_t natural_end = 0xffffffff;

// Polynomial of degree 4 in t = tan(angle / 2), for angles from 0 to a right angle.
// A circle meets a cylinder where a trigonometric polynomial of second order vanishes. In t = tan(angle / 2) this is a quartic, whose real
// roots in [0, 1] are isolated by bisection with bounds of its derivatives: closed formulas would lose digits at double roots.
struct Quartic {
    double a0, a1, a2, a3, a4;

    // (1 + t^2)^2 (constant + c1 cos + s1 sin + c2 cos 2 + s2 sin 2), which has the same roots.
    static Quartic of_trigonometric(double constant, double c1, double s1, double c2, double s2) {
        return {constant + c1 + c2, 2.0 * s1 + 4.0 * s2, 2.0 * constant - 6.0 * c2, 2.0 * s1 - 4.0 * s2, constant - c1 + c2};
    }
    [[nodiscard]] double value(double t) const { return (((a4 * t + a3) * t + a2) * t + a1) * t + a0; }
    [[nodiscard]] double slope(double t) const { return ((4.0 * a4 * t + 3.0 * a3) * t + 2.0 * a2) * t + a1; }

    // Root in an interval where the function is monotone: Newton steps inside a shrinking bracket.
    [[nodiscard]] double root_between(double low, double high, double value_low) const {
        double t = 0.5 * (low + high);
        for (int i = 0; i < 60; ++i) {
            const double here = value(t);
            ((here > 0.0) == (value_low > 0.0) ? low : high) = t;
            double next = t - here / slope(t);
            if (!(next > low && next < high)) next = 0.5 * (low + high);
            if (std::abs(next - t) < 1e-16) return next;
            t = next;
        }
        return t;
    }
    // Adds the angle of every root between low and high: the bound of the second derivative shows where there is no root, and
    // where there is at most one.
    void add_angles(double low, double high, std::vector<double>& angles) const {
        const double bend = 2.0 * std::abs(a2) + 6.0 * std::abs(a3) * high + 12.0 * std::abs(a4) * high * high;
        const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
        const double here = value(middle), steep = std::abs(slope(middle));
        if (std::abs(here) > steep * half + 0.5 * bend * half * half) return;
        if (steep > bend * half) {
            const double at_low = value(low);
            if ((at_low > 0.0) != (value(high) > 0.0)) angles.push_back(2.0 * std::atan(root_between(low, high, at_low)));
        } else if (half < 1e-10) {
            angles.push_back(2.0 * std::atan(middle));
        } else {
            add_angles(low, middle, angles);
            add_angles(middle, high, angles);
        }
    }
};

// Roots of c cos t + s sin t = value between 0 and a right angle.
void add_linear_roots(double c, double s, double value, std::vector<double>& found) {
    const double size = std::hypot(c, s);
    if (size <= std::abs(value)) return;
    const double phase = std::atan2(s, c), half = std::acos(value / size);
    for (double t : {phase - half, phase + half}) {
        if (t < 0.0) t += 2.0 * std::numbers::pi;
        if (t > 0.0 && t < right_angle) found.push_back(t);
    }
}

bool is_inside(const Capsule& inner, const Capsule& outer) {
    const double slack = tie * outer.radius;
    return signed_distance(outer, inner.a) <= slack - inner.radius && signed_distance(outer, inner.b) <= slack - inner.radius;
}

}  // namespace

// A quarter circle from the pole of a cap: centre + r (cos t pole + sin t radial).
struct ExposedSurface::Arc {
    Piece piece;
    double phi, r;
    Vec3 centre, pole, radial;
};

ExposedSurface::ExposedSurface(const std::vector<Capsule>& capsules) {
    for (std::size_t i = 0; i < capsules.size(); ++i) {
        // Of two capsules that contain each other the first stays.
        bool dropped = false;
        for (std::size_t j = 0; j < capsules.size() && !dropped; ++j)
            dropped = j != i && is_inside(capsules[i], capsules[j]) && (j < i || !is_inside(capsules[j], capsules[i]));
        if (!dropped) capsules_.push_back(capsules[i]);
    }
    near_.resize(capsules_.size());
    for (std::size_t i = 0; i < capsules_.size(); ++i) {
        const Vec3 along = capsules_[i].b - capsules_[i].a;
        const double length = along.norm();
        const Vec3 axis = length > 0.0 ? Vec3(along / length) : Vec3(Vec3::UnitZ());
        const Vec3 e1 = axis.unitOrthogonal();
        frames_.push_back({axis, e1, axis.cross(e1), length});
        for (std::size_t j = 0; j < capsules_.size(); ++j)
            if (j != i && gap(capsules_[i], capsules_[j]) < tie * capsules_[i].radius) near_[i].push_back(j);
    }
}

SurfacePoint ExposedSurface::point(std::size_t own, double phi, Piece piece, double parameter) const {
    const Frame& frame = frames_[own];
    const Capsule& capsule = capsules_[own];
    const Vec3 radial = std::cos(phi) * frame.e1 + std::sin(phi) * frame.e2;
    if (piece == Piece::side) return {capsule.a + parameter * frame.axis + capsule.radius * radial, radial, capsule.radius};
    const double sine = std::sin(parameter);
    const Vec3 pole = piece == Piece::cap_a ? Vec3(-frame.axis) : frame.axis;
    const Vec3 normal = sine * radial + std::cos(parameter) * pole;
    return {(piece == Piece::cap_a ? capsule.a : capsule.b) + capsule.radius * normal, normal, capsule.radius * capsule.radius * sine};
}

bool ExposedSurface::covers(std::size_t other, std::size_t own, const SurfacePoint& at) const {
    const Capsule& capsule = capsules_[other];
    const Vec3 offset = at.x - closest_on_axis(capsule, at.x);
    const double distance = offset.norm() - capsule.radius;
    if (distance < -tie * capsule.radius) return true;
    return distance <= tie * capsule.radius && other < own && offset.dot(at.normal) > 0.5 * capsule.radius;
}

// The candidates are where the arc meets the end spheres and the cylinder of the other capsule; the middle of each interval
// between two of them shows whether it is hidden, so a superfluous candidate does no harm.
void ExposedSurface::hide_arc(std::size_t own, std::size_t other, const Arc& arc, std::vector<Interval>& hidden) const {
    const Capsule& capsule = capsules_[other];
    const Frame& frame = frames_[other];
    const double r = arc.r, R = capsule.radius;
    const double to_surface = signed_distance(capsule, arc.centre);
    if (to_surface > r * (1.0 + tie)) return;
    const double along = (arc.centre - capsule.a).dot(frame.axis);
    if (to_surface < -r + tie * R && (r < R * (1.0 - tie) || (along > tie * R && along < frame.length - tie * R))) {
        // The end sphere lies inside; where it touches from inside, it touches along a curve only.
        hidden.push_back({0.0, right_angle});
        return;
    }
    thread_local std::vector<double> cuts;
    cuts.clear();
    for (const Vec3& end : {capsule.a, capsule.b}) {
        const Vec3 w = arc.centre - end;
        // Where |x - end|^2 = R^2 for x = centre + r (cos t pole + sin t radial).
        if (w.norm() > tie * R)
            add_linear_roots(2.0 * r * w.dot(arc.pole), 2.0 * r * w.dot(arc.radial), R * R - r * r - w.squaredNorm(), cuts);
        // On a shared sphere the other capsule's cylinder begins at the plane through the centre.
        if (frame.length > 0.0) add_linear_roots(r * arc.pole.dot(frame.axis), r * arc.radial.dot(frame.axis), -w.dot(frame.axis), cuts);
        if (frame.length == 0.0) break;
    }
    if (frame.length > 0.0) {
        const Vec3 w = arc.centre - capsule.a;
        const Vec3 across = w - w.dot(frame.axis) * frame.axis;
        // Where the distance from the axis is R: the square of the part of x - a across the axis, as a sum of cos, sin, cos 2t and sin 2t.
        const double p = arc.pole.dot(frame.axis), q = arc.radial.dot(frame.axis);
        Quartic::of_trigonometric(across.squaredNorm() - R * R + r * r * (1.0 - 0.5 * (p * p + q * q)), 2.0 * r * across.dot(arc.pole),
                                  2.0 * r * across.dot(arc.radial), -0.5 * r * r * (p * p - q * q), -r * r * p * q)
            .add_angles(0.0, 1.0, cuts);
    }
    cuts.push_back(right_angle);
    std::sort(cuts.begin(), cuts.end());
    double start = 0.0;
    bool open = false;
    for (const double cut : cuts) {
        if (cut <= start) continue;
        const bool now = covers(other, own, point(own, arc.phi, arc.piece, 0.5 * (start + cut)));
        if (now && open)
            hidden.back().high = cut;
        else if (now)
            hidden.push_back({start, cut});
        open = now;
        start = cut;
    }
}

void ExposedSurface::hide_side(std::size_t own, std::size_t other, double phi, std::vector<Interval>& hidden) const {
    // A line exactly on the surface (collinear capsules) is hidden by the capsule listed first: its radius is increased by
    // a tiny amount to find such a line, and the middle of the line is then tested.
    const Frame& frame = frames_[own];
    Capsule thicker = capsules_[other];
    if (frames_[other].length > 0.0 && frames_[other].axis.cross(frame.axis).norm() < 1e-9) thicker.radius *= 1.0 + 1e-12;
    const auto inside = line_interval(thicker, point(own, phi, Piece::side, 0.0).x, frame.axis);
    if (!inside || inside->high <= 0.0 || inside->low >= frame.length) return;
    const double middle = std::clamp(0.5 * (inside->low + inside->high), 0.0, frame.length);
    if (covers(other, own, point(own, phi, Piece::side, middle))) hidden.push_back(*inside);
}

std::uint32_t ExposedSurface::tag_at(std::size_t own, const Vec3& x) const {
    // Of several at the same place always the first is used, and the ends of the meridian's pieces are separate places:
    // rounding must not appear as a change of the pattern.
    constexpr double slack = 1e-8;
    std::size_t nearest = own;
    double minimum = 1e300;
    for (const std::size_t j : near_[own]) {
        const double distance = std::abs(signed_distance(capsules_[j], x)) / capsules_[j].radius;
        if (distance < minimum - slack) {
            minimum = distance;
            nearest = j;
        }
    }
    const double along = (x - capsules_[nearest].a).dot(frames_[nearest].axis);
    const double near = slack * capsules_[nearest].radius, length = frames_[nearest].length;
    std::uint32_t place = 0;
    for (const double seam : {-near, near, length - near, length + near}) place += along > seam ? 1 : 0;
    return static_cast<std::uint32_t>(5 * nearest) + place;
}

void ExposedSurface::add_parts(std::size_t own, double phi, Piece piece, double end, std::vector<Interval>& hidden,
                               std::vector<ExposedPart>& parts) const {
    std::sort(hidden.begin(), hidden.end(), [](const Interval& p, const Interval& q) { return p.low < q.low; });
    // The exposed parts are the gaps between the hidden ones, which may overlap.
    double at = 0.0;
    std::uint32_t tag = natural_end;
    const auto tag_of = [&](double parameter) { return tag_at(own, point(own, phi, piece, parameter).x); };
    for (const auto& stretch : hidden) {
        if (stretch.low > at) parts.push_back({piece, at, stretch.low, tag, tag_of(stretch.low)});
        if (stretch.high <= at) continue;
        at = stretch.high;
        if (at >= end) return;
        tag = tag_of(at);
    }
    parts.push_back({piece, at, end, tag, natural_end});
}

void ExposedSurface::meridian(std::size_t own, double phi, std::vector<ExposedPart>& parts) const {
    parts.clear();
    thread_local std::vector<Interval> hidden;
    const Frame& frame = frames_[own];
    const Vec3 radial = std::cos(phi) * frame.e1 + std::sin(phi) * frame.e2;
    for (const Piece piece : {Piece::cap_a, Piece::cap_b}) {
        hidden.clear();
        const bool first = piece == Piece::cap_a;
        const Arc arc{
            piece, phi, capsules_[own].radius, first ? capsules_[own].a : capsules_[own].b, first ? Vec3(-frame.axis) : frame.axis, radial};
        for (const std::size_t j : near_[own]) {
            hide_arc(own, j, arc, hidden);
            if (!hidden.empty() && hidden.back().low <= 0.0 && hidden.back().high >= right_angle) break;
        }
        add_parts(own, phi, piece, right_angle, hidden, parts);
    }
    if (frame.length == 0.0) return;
    hidden.clear();
    for (const std::size_t j : near_[own]) hide_side(own, j, phi, hidden);
    add_parts(own, phi, Piece::side, frame.length, hidden, parts);
}

}  // namespace porepack::shapes
