#include "pouring/dem/contact_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

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
                const int arcs = std::max(8, static_cast<int>(std::ceil(std::numbers::pi * curve.rim_radius / longest_m)));
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
    double longest = 1e300;
    for (const Shape& shape : shapes) {
        longest = std::min(longest, 0.25 * maximum_feret_diameter(shape));
        // Along a step shorter than the thickness, the distance from a grain that is not convex has one minimum. A piece has fifteen steps;
        // an arc may be twice as long as an edge.
        if (!is_convex(shape)) longest = std::min(longest, 6.0 * smallest_diameter(shape));
    }
    const bool convex = std::all_of(shapes.begin(), shapes.end(), is_convex);
    for (std::size_t s = 0; s < shapes.size(); ++s) pieces[s] = contact_pieces(shapes[s], longest, convex ? 1e300 : longest);
    return pieces;
}

}  // namespace porepack::pouring::dem
