#include "pouring/dem/contact_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

// Gauss' rule with eight points on 0 to 1.
constexpr std::array<double, 8> gauss_point = {0.0198550717512319, 0.1016667612931866, 0.2372337950418355, 0.4082826787521751,
                                               0.5917173212478249, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681};
constexpr std::array<double, 8> gauss_weight = {0.0506142681451881, 0.1111905172266872, 0.1568533229389436, 0.1813418916891810,
                                                0.1813418916891810, 0.1568533229389436, 0.1111905172266872, 0.0506142681451881};

double seventh(double x) {
    const double x2 = x * x;
    return x2 * x2 * x2 * x;
}

// Where a continuous function is within `small` of zero, between two places where its signs differ (Illinois).
template <typename F>
double zero_between(const F& f, double a, double at_a, double b, double at_b, double small) {
    int side = 0;
    for (int step = 0; step < 30 && std::abs(b - a) > 1e-9; ++step) {
        const double c = std::clamp((a * at_b - b * at_a) / (at_b - at_a), std::min(a, b), std::max(a, b)), at_c = f(c);
        if (std::abs(at_c) <= small) return c;
        if ((at_c > 0.0) == (at_b > 0.0)) {
            b = c;
            at_b = at_c;
            if (side == -1) at_a *= 0.5;
            side = -1;
        } else {
            a = c;
            at_a = at_c;
            if (side == 1) at_b *= 0.5;
            side = 1;
        }
    }
    return 0.5 * (a + b);
}

// A place nearer than those on both sides of it.
struct NearPlace {
    double s = 0.0, distance = 0.0;
    bool inner = false;  // not at an end
};

// The near places of a piece, the nearest first: one before a convex surface; before any other, those that five samples tell apart.
struct NearPlaces {
    std::array<NearPlace, 6> places = {};
    std::size_t count = 0;
    double at_start = 0.0, at_end = 0.0;  // distances
    double bound = 0.0;                   // no place is nearer

    [[nodiscard]] const NearPlace& nearest() const { return places[0]; }
};

// Where the slope is zero, between a fall and a rise. `uncertain`: the distance there is not larger than the smallest one by more than
// this.
template <typename Slope>
NearPlace valley(const Slope& slope, double low, double at_low, double high, double at_high, double length, double& uncertain) {
    constexpr double width = 1e-4, level = 1e-6;
    NearPlace place{.s = low, .distance = 1e300, .inner = true};
    uncertain = (high - low) * length;
    int side = 0;
    for (int step = 0; step < 40 && high - low > width; ++step) {
        const double s = std::clamp((low * at_high - high * at_low) / (at_high - at_low), low + 1e-6, high - 1e-6);
        double away = 0.0;
        const double here = slope(s, away);
        if (away < place.distance) {
            place.distance = away;
            place.s = s;
        }
        uncertain = (high - low) * length;
        if (std::abs(here) < level) {
            uncertain = level * length;
            break;
        }
        if (here > 0.0) {
            high = s;
            at_high = here;
            if (side == -1) at_low *= 0.5;
            side = -1;
        } else {
            low = s;
            at_low = here;
            if (side == 1) at_high *= 0.5;
            side = 1;
        }
    }
    return place;
}

NearPlaces near_places(const ContactPiece& piece, const Surface& surface) {
    Vec3 outward, tangent;
    const auto slope = [&](double s, double& away) {
        const Vec3 x = piece.at(s, &tangent);
        away = surface.distance(x, outward);
        return outward.dot(tangent);
    };
    constexpr std::size_t most = 5;
    const std::size_t samples = surface.convex ? 2 : most;
    std::array<double, most> away{}, rise{};
    for (std::size_t i = 0; i < samples; ++i) rise[i] = slope(static_cast<double>(i) / static_cast<double>(samples - 1), away[i]);
    NearPlaces found{.at_start = away[0], .at_end = away[samples - 1]};
    found.places[found.count++] =
        found.at_start <= found.at_end ? NearPlace{.s = 0.0, .distance = found.at_start} : NearPlace{.s = 1.0, .distance = found.at_end};
    double uncertain = 0.0;
    found.bound = 1e300;
    for (std::size_t i = 0; i + 1 < samples; ++i) {
        const double from = static_cast<double>(i) / static_cast<double>(samples - 1),
                     to = static_cast<double>(i + 1) / static_cast<double>(samples - 1);
        if (rise[i] < 0.0 && rise[i + 1] > 0.0)
            found.places[found.count++] = valley(slope, from, rise[i], to, rise[i + 1], piece.speed(0.0), uncertain);
        // A distance changes by no more than the length; the parameter is fastest at the beginning.
        found.bound = std::min(found.bound, 0.5 * (away[i] + away[i + 1] - (to - from) * piece.speed(0.0)));
    }
    std::sort(found.places.begin(), found.places.begin() + static_cast<std::ptrdiff_t>(found.count),
              [](const NearPlace& one, const NearPlace& other) { return one.distance < other.distance; });
    if (surface.convex) found.bound = found.nearest().distance - uncertain;
    return found;
}

bool touch_point(const ContactPiece& piece, const Surface& surface, PieceContact& contact, double& gap) {
    const double overlap = piece.radius - surface.distance(piece.start, contact.normal);
    gap = -overlap;
    if (overlap <= 0.0) return false;
    contact.overlap = overlap;
    contact.weight = seventh(overlap);
    contact.potential = overlap * contact.weight;
    contact.at = piece.start - (piece.radius - 0.5 * overlap) * contact.normal;
    return true;
}

// What a disc of an axis counts where it is nearest to the other body in the direction `towards`: nothing if that lies beyond the ends of
// the axis, where the rim or the flat end touches, or in the hole. Smoothly; `slope`: per length along the axis.
double share_of_disc(const ContactPiece& piece, double s, double distance, double towards_along, double& slope) {
    slope = 0.0;
    // The radius at which the other body's nearest point lies must be in the outer half of the wall, or beyond.
    if (distance * std::sqrt(std::max(0.0, 1.0 - towards_along * towards_along)) <= 0.5 * (piece.radius + piece.hole_radius)) return 0.0;
    const double along = s * piece.length + piece.radius * towards_along;
    const double from_start = piece.before + along, from_end = piece.after + piece.length - along;
    const double share = std::min(from_start, from_end) / piece.taper;
    if (share >= 1.0) return 1.0;
    if (share <= 0.0) return 0.0;
    slope = (from_start < from_end ? 6.0 : -6.0) * share * (1.0 - share) / piece.taper;
    return share * share * (3.0 - 2.0 * share);
}

}  // namespace

Vec3 ContactPiece::at(double s, Vec3* tangent) const {
    if (kind == Kind::arc) {
        const double t = s * half_tangent, per = 1.0 / (1.0 + t * t), c = (1.0 - t * t) * per, sine = 2.0 * t * per;
        if (tangent != nullptr) *tangent = (c * v - sine * u) / rim_radius;
        return start + c * u + sine * v;
    }
    if (tangent != nullptr) *tangent = along / length;
    return start + s * along;
}

double ContactPiece::speed(double s) const {
    if (kind != Kind::arc) return length;
    const double t = s * half_tangent;
    return 2.0 * rim_radius * half_tangent / (1.0 + t * t);
}

ContactPiece ContactPiece::moved(const Eigen::Matrix3d& turn_by, const Vec3& shift) const {
    ContactPiece piece = *this;
    piece.start = turn_by * start + shift;
    if (kind == Kind::segment || kind == Kind::axis) piece.along = turn_by * along;
    if (kind == Kind::arc) {
        piece.u = turn_by * u;
        piece.v = turn_by * v;
    }
    return piece;
}

std::vector<ContactPiece> contact_pieces(const Shape& shape, double longest_m, double longest_axis_m) {
    std::vector<ContactPiece> pieces;
    const double per_length = 0.1 * smallest_diameter(shape);
    const auto add_segment = [&](const Vec3& a, const Vec3& b, double radius) {
        const double length = (b - a).norm();
        const int count = std::max(1, static_cast<int>(std::ceil(length / longest_m - 1e-9)));
        for (int i = 0; i < count; ++i)
            pieces.push_back({.kind = ContactPiece::Kind::segment,
                              .start = a + (static_cast<double>(i) / count) * (b - a),
                              .along = (b - a) / count,
                              .length = length / count,
                              .radius = radius,
                              .per_length = per_length});
    };
    if (shape.body == nullptr) {
        std::vector<Vec3> ends;
        for (const Capsule& capsule : shape.capsules) {
            if (capsule.a != capsule.b) add_segment(capsule.a, capsule.b, capsule.radius);
            for (const Vec3& end : {capsule.a, capsule.b}) {
                if (std::any_of(ends.begin(), ends.end(), [&](const Vec3& known) { return (known - end).norm() < 1e-6 * per_length; }))
                    continue;
                ends.push_back(end);
                pieces.push_back({.start = end, .radius = capsule.radius});
            }
        }
        return pieces;
    }
    for (const ContactCurve& curve : shape.body->contact_curves()) switch (curve.kind) {
            case ContactCurve::Kind::corner:
                pieces.push_back({.start = curve.a, .radius = curve.radius});
                break;
            case ContactCurve::Kind::edge:
                add_segment(curve.a, curve.b, curve.radius);
                break;
            case ContactCurve::Kind::axis: {
                const double length = (curve.b - curve.a).norm();
                const int count = std::max(1, static_cast<int>(std::ceil(length / longest_axis_m - 1e-9)));
                for (int i = 0; i < count; ++i)
                    pieces.push_back({.kind = ContactPiece::Kind::axis,
                                      .start = curve.a + (static_cast<double>(i) / count) * (curve.b - curve.a),
                                      .along = (curve.b - curve.a) / count,
                                      .length = length / count,
                                      .radius = curve.radius,
                                      .hole_radius = curve.hole_radius,
                                      .per_length = per_length,
                                      .before = length * i / count,
                                      .after = length * (count - 1 - i) / count,
                                      .taper = std::max(2.0 * shape.body->rounding(), 0.02 * per_length)});
                break;
            }
            case ContactCurve::Kind::rim: {
                constexpr int arcs = 8;
                const Vec3 first = curve.rim_radius * curve.b.unitOrthogonal(), second = curve.b.cross(first);
                const double turn = 2.0 * std::numbers::pi / arcs;
                for (int i = 0; i < arcs; ++i) {
                    const double c = std::cos(i * turn), sine = std::sin(i * turn);
                    pieces.push_back({.kind = ContactPiece::Kind::arc,
                                      .start = curve.a,
                                      .u = c * first + sine * second,
                                      .v = c * second - sine * first,
                                      .rim_radius = curve.rim_radius,
                                      .half_tangent = std::tan(0.5 * turn),
                                      .length = turn * curve.rim_radius,
                                      .radius = curve.radius,
                                      .per_length = per_length});
                }
                break;
            }
        }
    std::erase_if(pieces, [](const ContactPiece& piece) { return piece.kind != ContactPiece::Kind::point && !(piece.length > 0.0); });
    return pieces;
}

bool touch(const ContactPiece& piece, const Surface& surface, PieceContact& contact, double& gap) {
    if (piece.kind == ContactPiece::Kind::point) return touch_point(piece, surface, contact, gap);
    Vec3 outward, tangent;
    gap = surface.distance(piece.at(0.5), outward) - 0.5 * piece.speed(0.0) - piece.radius;
    if (gap > 0.0) return false;
    const NearPlaces near = near_places(piece, surface);
    gap = std::max(0.0, near.bound - piece.radius);

    const auto overlap_at = [&](double s) { return piece.radius - surface.distance(piece.at(s), outward); };
    const Vec3 about = piece.at(near.nearest().s);
    Vec3 push = Vec3::Zero(), at = Vec3::Zero(), moment = Vec3::Zero();
    double potential = 0.0, weight = 0.0, covered_low = 2.0, covered_high = -1.0;
    for (std::size_t n = 0; n < near.count; ++n) {
        const NearPlace& place = near.places[n];
        const double deepest = piece.radius - place.distance;
        if (deepest <= 0.0 || (place.s >= covered_low && place.s <= covered_high)) continue;
        double low = piece.radius - near.at_start, high = piece.radius - near.at_end;  // overlaps at the ends
        const double small = 0.01 * deepest;                                           // to the power 8
        low = low >= 0.0 ? 0.0 : zero_between(overlap_at, 0.0, low, place.s, deepest, small);
        high = high >= 0.0 ? 1.0 : zero_between(overlap_at, place.s, deepest, 1.0, high, small);
        covered_low = std::min(covered_low, low);
        covered_high = std::max(covered_high, high);
        // On both sides of the near place, where a curve often passes from one feature of the other body to the next.
        for (const auto& [from, to] : {std::pair(low, place.s), std::pair(place.s, high)}) {
            if (!(to > from)) continue;
            for (std::size_t i = 0; i < gauss_point.size(); ++i) {
                const double s = from + gauss_point[i] * (to - from);
                const Vec3 x = piece.at(s, &tangent);
                const double away = surface.distance(x, outward), overlap = std::max(0.0, piece.radius - away);
                double part = gauss_weight[i] * (to - from) * piece.speed(s) / piece.per_length * seventh(overlap);
                if (piece.kind == ContactPiece::Kind::axis) {
                    double slope = 0.0;
                    const double whole = part;
                    part *= share_of_disc(piece, s, away, -outward.dot(tangent), slope);
                    push += 0.125 * whole * overlap * slope * tangent;
                    if (part == 0.0) continue;
                }
                const Vec3 from_about = x - (piece.radius - 0.5 * overlap) * outward - about;
                potential += part * overlap;
                weight += part;
                push += part * outward;
                at += part * from_about;
                moment += part * from_about.cross(outward);
            }
        }
    }
    contact.weight = push.norm();
    if (!(weight > 0.0) || !(contact.weight > 0.0)) return false;
    contact.potential = potential;
    contact.overlap = potential / weight;
    contact.normal = push / contact.weight;
    // One force in place of many, where it has their moment (but for a part about the normal).
    at /= weight;
    contact.at = about + at + contact.normal.cross(moment - at.cross(push)) / contact.weight;
    return true;
}

double share_of(const PieceContact& contact, double sum) {
    return contact.weight / (std::sqrt(std::sqrt(sum)) * std::sqrt(sum) * contact.overlap);
}

}  // namespace porepack::pouring::dem
