#include "pouring/dem/piece_contact.hpp"

#include <algorithm>
#include <cmath>

#include "pouring/dem/course.hpp"
#include "pouring/dem/piece_rows.hpp"
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
// the axis, or less deep below one of them than below the round side: there the rim or the flat end is in contact. Smoothly; `slope`: per
// length along the axis, away from the nearer end; it is also that per distance.
double share_of_disc(const ContactPiece& piece, double s, double distance, double towards_along, double& slope, bool& from_first_end) {
    slope = 0.0;
    // What lies in the hole is in contact with rims. Between the middle of the wall and the outside, overlaps stay below deepest_overlap.
    if (distance * std::sqrt(std::max(0.0, 1.0 - towards_along * towards_along)) <= 0.5 * (piece.radius + piece.hole_radius)) return 0.0;
    const double along = s * piece.length + piece.radius * towards_along;
    const double from_start = piece.before + along, from_end = piece.after + piece.length - along;
    const double share = (std::min(from_start, from_end) - std::max(0.0, piece.radius - distance)) / piece.taper;
    if (share >= 1.0) return 1.0;
    if (share <= 0.0) return 0.0;
    slope = 6.0 * share * (1.0 - share) / piece.taper;
    from_first_end = from_start < from_end;
    return share * share * (3.0 - 2.0 * share);
}

// The share S of a disc at s depends on s + R tau, with tau = -outward.t the part along the axis t of the direction in which the disc is
// nearest: a shift of the disc changes tau by -H t, with H the second derivatives of the distance, and a turn by -t x outward.
void add_change_of_share(const ContactPiece& piece, const Surface& surface, const Vec3& x, const Vec3& t, const Vec3& outward,
                         double change, ContactSum& sum) {
    const double step = 1e-6 * piece.radius;
    Vec3 next;
    (void)surface.distance(x + step * t, next);
    sum.add(change / step * (next - outward), x - sum.about);
    sum.moment += change * t.cross(outward);
}

// Gauss' rule from 0 to 1; what it does not need lies at 0 and weighs nothing.
struct GaussRow {
    Row s = {}, weight = {};
};
template <unsigned Points>
GaussRow gauss_row() {
    GaussRow row;
    std::size_t n = 0;
    shapes::for_gauss_points<Points>(0.0, 1.0, [&](double s, double weight) {
        row.s[n] = s;
        row.weight[n++] = weight;
    });
    return row;
}

// From one place to another, between which the overlap rises or falls.
template <unsigned Points>
void add_part(const ContactPiece& piece, const Surface& surface, double from, double to, ContactSum& sum) {
    static const GaussRow rule = gauss_row<Points>();
    PlaceRow row;
    DistanceRow found;
    Row weights;
    row.points.count = Points;
    for (std::size_t n = 0; n < weights.size(); ++n) {
        row.s[n] = from + rule.s[n] * (to - from);
        weights[n] = rule.weight[n] * (to - from) / piece.per_length;
    }
    place(piece, row);
    surface.distances(row.points, found);
    for (std::size_t n = 0; n < weights.size(); ++n) weights[n] *= row.speed[n];
    if (piece.kind == ContactPiece::Kind::axis)
        for (std::size_t n = 0; n < Points; ++n) {
            const int i = static_cast<int>(n);
            const Vec3 outward = found.outward.at(i), tangent = row.tangents.at(i);
            const double away = found.distance[n], overlap = std::max(0.0, piece.radius - away);
            double slope = 0.0;
            bool from_first_end = true;
            const double whole = weights[n], share = share_of_disc(piece, row.s[n], away, -outward.dot(tangent), slope, from_first_end);
            weights[n] *= share;
            if (slope == 0.0 || overlap == 0.0) continue;
            const double change = 0.125 * whole * seventh(overlap) * overlap * slope;
            add_change_of_share(piece, surface, row.points.at(i), tangent, outward, (from_first_end ? 1.0 : -1.0) * change * piece.radius,
                                sum);
            sum.add(-change * outward, row.points.at(i) - sum.about);
        }
    add_row(row, found, weights, piece.radius, sum);
}

// Where the distance grows in the same direction at both ends, a convex body is flat between them; elsewhere, the part may pass from one
// feature of the other body to the next, where the curvature jumps.
bool is_flat(const ContactPiece& piece, const Surface& surface, double from, double to) {
    if (!surface.convex() || piece.kind == ContactPiece::Kind::axis) return false;
    Vec3 one, other;
    (void)surface.distance(piece.at(from), one);
    (void)surface.distance(piece.at(to), other);
    return (one - other).squaredNorm() < 1e-18;
}

}  // namespace

void Surface::distances(const PointRow& points, DistanceRow& found) const {
    Vec3 outward;
    for (int i = 0; i < points.count; ++i) {
        const double away = distance(points.at(i), outward);
        found.set(i, away, outward);
    }
    found.clear_from(points.count);
}

bool contact_of(const ContactPiece& piece, const Surface& surface, PieceContact& contact, double& gap) {
    if (piece.kind == ContactPiece::Kind::point) return contact_of_point(piece, surface, contact, gap);
    Vec3 outward;
    gap = surface.distance(piece.at(0.5), outward) - 0.5 * piece.speed(0.0) - piece.radius;
    if (gap > 0.0) return false;
    Course course(piece, surface);
    gap = course.bound() - piece.radius;
    if (gap >= 0.0) return false;
    course.find_turns();
    gap = std::max(0.0, course.bound() - piece.radius);
    const Place nearest = course.nearest();
    if (nearest.distance >= piece.radius) return false;
    const auto overlap = [&](std::size_t place) { return piece.radius - course[place].distance; };
    const auto overlap_at = [&](double s) { return piece.radius - surface.distance(piece.at(s), outward); };
    const double small = 0.01 * (piece.radius - nearest.distance);  // to the power 8
    const auto end_between = [&](std::size_t in, std::size_t out) {
        if (overlap(out) >= 0.0) return course[out].s;
        return zero_between(overlap_at, course[in].s, overlap(in), course[out].s, overlap(out), small);
    };
    ContactSum sum{.about = piece.at(nearest.s)};
    for (std::size_t part = 0; part < course.parts(); ++part) {
        // The first and the last place in contact.
        std::size_t first = course.turn(part), last = course.turn(part + 1);
        while (first < last && overlap(first) <= small) ++first;
        while (last > first && overlap(last) <= small) --last;
        if (overlap(first) <= small) continue;
        const double from = first > course.turn(part) ? end_between(first, first - 1) : course[first].s;
        const double to = last < course.turn(part + 1) ? end_between(last, last + 1) : course[last].s;
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
