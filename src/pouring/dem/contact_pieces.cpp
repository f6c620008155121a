#include "pouring/dem/contact_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pouring/uses.hpp"
#include "shapes/quadrature.hpp"

namespace porepack::pouring::dem {
namespace {

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

// A piece from one end to the other by places where the distance from a surface rises or falls only between neighbours.
struct Place {
    double s, distance;
};
struct Course {
    std::vector<Place> places;
    double bound = 0.0;  // no place of the piece is nearer
};

// Where the slope is zero, between a fall and a rise. `uncertain`: the distance there is not larger than the smallest one by more than
// this.
template <typename Slope>
Place valley(const Slope& slope, double low, double at_low, double high, double at_high, double length, double& uncertain) {
    constexpr double width = 1e-4, level = 1e-5;
    Place place{.s = low, .distance = 1e300};
    uncertain = (high - low) * length;
    int side = 0;
    for (int step = 0; step < 40 && high - low > width; ++step) {
        const double s = std::clamp((low * at_high - high * at_low) / (at_high - at_low), low + 1e-6, high - 1e-6);
        double away = 0.0;
        const double here = slope(s, away);
        if (away < place.distance) place = {s, away};
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

// Stretches that may be in contact are halved until they have one minimum at most.
void follow(const ContactPiece& piece, const Surface& surface, Course& course) {
    struct Sample {
        double s, distance, slope;
    };
    Vec3 outward, tangent;
    const auto slope_at = [&](double s, double& away) {
        const Vec3 x = piece.at(s, &tangent);
        away = surface.distance(x, outward);
        return outward.dot(tangent);
    };
    const auto sample = [&](double s) {
        Sample found{.s = s, .distance = 0.0, .slope = 0.0};
        found.slope = slope_at(s, found.distance);
        return found;
    };
    // The parameter is fastest at the beginning. A convex body may be near an arc at both of its ends.
    const double speed = piece.speed(0.0);
    const double feature = piece.kind == ContactPiece::Kind::arc ? std::min(surface.feature(), 0.5 * piece.rim_radius) : surface.feature();
    thread_local std::vector<Sample> ends;  // of the stretches to come, the next one last
    Sample from = sample(0.0);
    ends.assign(1, sample(1.0));
    course.places.assign(1, {from.s, from.distance});
    course.bound = 1e300;
    while (!ends.empty()) {
        const Sample to = ends.back();
        const double length = (to.s - from.s) * speed;
        // From one point to another, the distance changes by no more than the way.
        double bound = std::min({from.distance, to.distance, 0.5 * (from.distance + to.distance - length)});
        if (bound < piece.radius && length > feature) {
            ends.push_back(sample(0.5 * (from.s + to.s)));
            continue;
        }
        if (from.slope < 0.0 && to.slope > 0.0 && bound < piece.radius) {
            double uncertain = 0.0;
            course.places.push_back(valley(slope_at, from.s, from.slope, to.s, to.slope, speed, uncertain));
            bound = std::max(bound, std::min({from.distance, to.distance, course.places.back().distance - uncertain}));
        } else if (surface.feature() == Surface::convex && piece.kind != ContactPiece::Kind::arc) {
            bound = std::min(from.distance, to.distance);
        }
        course.bound = std::min(course.bound, bound);
        course.places.push_back({to.s, to.distance});
        from = to;
        ends.pop_back();
    }
}

bool contact_of_point(const ContactPiece& piece, const Surface& surface, PieceContact& contact, double& gap) {
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
// the axis, where the rim or the flat end is in contact. Smoothly; `slope`: per length along the axis.
double share_of_disc(const ContactPiece& piece, double s, double distance, double towards_along, double& slope) {
    slope = 0.0;
    // What lies in the hole is in contact with rims. Between the middle of the wall and the outside, overlaps stay below deepest_overlap.
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

namespace {

// `longest_m`: of a piece of an edge; `longest_axis_m`: of an axis.
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
        std::vector<ContactPiece> ends;
        for (const Capsule& capsule : shape.capsules) {
            if (capsule.a != capsule.b) add_segment(capsule.a, capsule.b, capsule.radius);
            for (const Vec3& end : {capsule.a, capsule.b}) {
                const bool known = std::any_of(ends.begin(), ends.end(), [&](const ContactPiece& one) {
                    return (one.start - end).norm() < 1e-6 * per_length && one.radius >= capsule.radius;
                });
                if (!known) ends.push_back({.start = end, .radius = capsule.radius});
            }
        }
        pieces.insert(pieces.end(), ends.begin(), ends.end());
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

}  // namespace

bool is_convex(const Shape& shape) {
    return shape.body != nullptr ? shape.body->convex() : shape.capsules.size() == 1;
}

std::vector<std::vector<ContactPiece>> pieces_of(const std::vector<Shape>& shapes) {
    std::vector<std::vector<ContactPiece>> pieces(shapes.size());
    if (std::none_of(shapes.begin(), shapes.end(), [](const Shape& shape) { return shape.body != nullptr; })) return pieces;
    double longest = 1e300;
    for (const Shape& shape : shapes) longest = std::min(longest, 0.25 * maximum_feret_diameter(shape));
    const bool convex = std::all_of(shapes.begin(), shapes.end(), is_convex);
    for (std::size_t s = 0; s < shapes.size(); ++s) pieces[s] = contact_pieces(shapes[s], longest, convex ? 1e300 : longest);
    return pieces;
}

namespace {

// The sum over the parts of a piece of what a shift and a turn of the piece change.
struct Integral {
    Vec3 about;  // a point near the contact
    Vec3 push = Vec3::Zero(), at = Vec3::Zero(), moment = Vec3::Zero();
    double potential = 0.0, weight = 0.0;

    void add(const Vec3& force, const Vec3& from_about) {
        push += force;
        moment += from_about.cross(force);
    }
};

// The share S of a disc at s depends on s + R tau, with tau = -outward.t the part along the axis t of the direction in which the disc is
// nearest: a shift of the disc changes tau by -H t, with H the second derivatives of the distance, and a turn by -t x outward.
void add_change_of_share(const ContactPiece& piece, const Surface& surface, const Vec3& x, const Vec3& t, const Vec3& outward,
                         double change, Integral& sum) {
    const double step = 1e-6 * piece.radius;
    Vec3 next;
    (void)surface.distance(x + step * t, next);
    sum.add(change / step * (next - outward), x - sum.about);
    sum.moment += change * t.cross(outward);
}

// From one place to another, between which the overlap rises or falls.
template <unsigned Points>
void add_part(const ContactPiece& piece, const Surface& surface, double from, double to, Integral& sum) {
    Vec3 outward, tangent;
    shapes::for_gauss_points<Points>(from, to, [&](double s, double width) {
        const Vec3 x = piece.at(s, &tangent);
        const double away = surface.distance(x, outward), overlap = std::max(0.0, piece.radius - away);
        const Vec3 from_about = x - sum.about;
        const double whole = width * piece.speed(s) / piece.per_length * seventh(overlap);
        double part = whole;
        if (piece.kind == ContactPiece::Kind::axis) {
            double slope = 0.0;
            part *= share_of_disc(piece, s, away, -outward.dot(tangent), slope);
            if (slope != 0.0) add_change_of_share(piece, surface, x, tangent, outward, 0.125 * whole * overlap * slope * piece.radius, sum);
        }
        sum.potential += part * overlap;
        sum.weight += part;
        sum.add(part * outward, from_about);
        sum.at += part * (from_about - (piece.radius - 0.5 * overlap) * outward);
    });
}

// Where the distance grows in the same direction at both ends, a convex body is flat between them; elsewhere, the part may pass from one
// feature of the other body to the next, where the curvature jumps.
bool is_flat(const ContactPiece& piece, const Surface& surface, double from, double to) {
    if (surface.feature() != Surface::convex || piece.kind == ContactPiece::Kind::axis) return false;
    Vec3 one, other;
    (void)surface.distance(piece.at(from), one);
    (void)surface.distance(piece.at(to), other);
    return (one - other).squaredNorm() < 1e-18;
}

}  // namespace

bool contact_of(const ContactPiece& piece, const Surface& surface, PieceContact& contact, double& gap) {
    if (piece.kind == ContactPiece::Kind::point) return contact_of_point(piece, surface, contact, gap);
    Vec3 outward;
    gap = surface.distance(piece.at(0.5), outward) - 0.5 * piece.speed(0.0) - piece.radius;
    if (gap > 0.0) return false;
    thread_local Course course;
    follow(piece, surface, course);
    gap = std::max(0.0, course.bound - piece.radius);

    const auto& places = course.places;
    const auto nearest =
        std::min_element(places.begin(), places.end(), [](const Place& one, const Place& other) { return one.distance < other.distance; });
    if (nearest->distance >= piece.radius) return false;
    const auto overlap_at = [&](double s) { return piece.radius - surface.distance(piece.at(s), outward); };
    const double small = 0.01 * (piece.radius - nearest->distance);  // to the power 8
    Integral sum{.about = piece.at(nearest->s)};
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
        double from = places[i].s, to = places[i + 1].s;
        const double at_from = piece.radius - places[i].distance, at_to = piece.radius - places[i + 1].distance;
        if (std::max(at_from, at_to) <= small) continue;
        if (at_from < 0.0) from = zero_between(overlap_at, from, at_from, to, at_to, small);
        if (at_to < 0.0) to = zero_between(overlap_at, places[i].s, at_from, to, at_to, small);
        if (!(to > from)) continue;
        if (is_flat(piece, surface, from, to))
            add_part<6>(piece, surface, from, to, sum);
        else
            add_part<16>(piece, surface, from, to, sum);
    }
    contact.weight = sum.push.norm();
    if (!(sum.weight > 0.0) || !(contact.weight > 0.0)) return false;
    contact.potential = sum.potential;
    contact.overlap = sum.potential / sum.weight;
    contact.normal = sum.push / contact.weight;
    // One force in place of many, where it has their moment, but for the part about the normal.
    contact.twist = contact.normal.dot(sum.moment) / contact.weight;
    const Vec3 at = sum.at / sum.weight;
    contact.at = sum.about + at + contact.normal.cross(sum.moment - at.cross(sum.push)) / contact.weight;
    return true;
}

double share_of(const PieceContact& contact, double sum) {
    return contact.weight / (std::sqrt(std::sqrt(sum)) * std::sqrt(sum) * contact.overlap);
}

double square_of(const PieceContact& contact, double sum) {
    return contact.potential / (std::sqrt(std::sqrt(sum)) * std::sqrt(sum));
}

}  // namespace porepack::pouring::dem
