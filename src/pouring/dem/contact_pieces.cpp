#include "pouring/dem/contact_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

struct Place {
    double s, distance;
};

constexpr double level = 1e-5;  // a slope below this is none

// Where the slope is zero, between a fall and a rise. `uncertain`: the distance there is not larger than the smallest one by more than
// this.
template <typename Slope>
Place valley(const Slope& slope, double low, double at_low, double high, double at_high, double length, double& uncertain) {
    constexpr double width = 1e-4;
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

// A piece from one end to the other. Its turns are places between which the distance from the surface only rises or only falls (but for
// `level`).
class Course {
public:
    /// Fifteen steps from place to place; along a step, there is one nearest place at most (pieces_of).
    Course(const ContactPiece& piece, const Surface& surface) : piece_(piece), surface_(surface) {
        row_.points.count = PointRow::most;
        for (std::size_t i = 0; i < samples; ++i) row_.s[i] = static_cast<double>(i) / (samples - 1);
        place(piece, row_);
        surface.distances(row_.points, found_);
        // From one point to another, the distance changes by no more than the way.
        bound_ = bound_between(row_, found_.distance);
    }
    [[nodiscard]] double bound() const { return bound_; }  ///< no place of the piece is nearer
    void find_turns();
    [[nodiscard]] std::size_t parts() const { return turn_count_ - 1; }
    [[nodiscard]] std::size_t turn(std::size_t n) const { return turns_[n]; }
    [[nodiscard]] const Place& operator[](std::size_t place) const { return places_[place]; }
    [[nodiscard]] const Place& nearest() const { return places_[nearest_]; }

private:
    static constexpr std::size_t samples = PointRow::most;
    static bool nearer(const Place& one, const Place& other) { return one.distance < other.distance; }
    void add(const Place& place) {
        if (count_ == 0 || place.distance < places_[nearest_].distance) nearest_ = count_;
        places_[count_++] = place;
    }

    const ContactPiece& piece_;
    const Surface& surface_;
    PlaceRow row_;
    DistanceRow found_;
    double bound_;
    std::array<Place, 2 * samples> places_;
    std::array<std::size_t, 2 * samples> turns_;  // numbers of places; the first and the last one are among them
    std::size_t count_ = 0, turn_count_ = 0, nearest_ = 0;
};

void Course::find_turns() {
    Row slopes;
    find_slopes(row_, found_, slopes);
    const auto slope_at = [&](double s, double& away) {
        Vec3 outward, tangent;
        away = surface_.distance(piece_.at(s, &tangent), outward);
        return outward.dot(tangent);
    };
    const bool one_minimum = surface_.convex() && piece_.kind != ContactPiece::Kind::arc;
    turns_[turn_count_++] = 0;
    bound_ = 1e300;
    int way = 0;            // of the distance: 1 rises, -1 falls
    std::size_t since = 0;  // the last place with such a slope
    for (std::size_t i = 0; i < samples; ++i) {
        const Place to = {row_.s[i], found_.distance[i]};
        const double slope = slopes[i];
        if (i > 0) {
            const Place from = {row_.s[i - 1], found_.distance[i - 1]};
            const double length = (to.s - from.s) * row_.speed[i - 1], lower = std::min(from.distance, to.distance);
            const bool has_valley = slopes[i - 1] < -level && slope > level;
            double bound = std::min(lower, 0.5 * (from.distance + to.distance - length));
            if (has_valley && bound < piece_.radius) {
                double uncertain = 0.0;
                const Place lowest = valley(slope_at, from.s, slopes[i - 1], to.s, slope, row_.speed[i - 1], uncertain);
                add(lowest);
                bound = std::max(bound, std::min(lower, lowest.distance - uncertain));
            } else if (one_minimum && !has_valley) {
                bound = lower - level * length;
            }
            bound_ = std::min(bound_, bound);
        }
        add(to);
        const int now = slope > level ? 1 : slope < -level ? -1 : 0;
        if (now == 0) continue;
        if (way == -now) {
            const auto one = places_.begin() + static_cast<std::ptrdiff_t>(since),
                       end = places_.begin() + static_cast<std::ptrdiff_t>(count_);
            const auto turn = now > 0 ? std::min_element(one, end, nearer) : std::max_element(one, end, nearer);
            if (const auto n = static_cast<std::size_t>(turn - places_.begin()); n > turns_[turn_count_ - 1]) turns_[turn_count_++] = n;
        }
        way = now;
        since = count_ - 1;
    }
    if (turns_[turn_count_ - 1] + 1 < count_) turns_[turn_count_++] = count_ - 1;
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

void Surface::distances(const PointRow& points, DistanceRow& found) const {
    Vec3 outward;
    for (int i = 0; i < points.count; ++i) {
        const double away = distance(points.at(i), outward);
        found.set(i, away, outward);
    }
    found.clear_from(points.count);
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
    if (std::none_of(shapes.begin(), shapes.end(), [](const Shape& shape) { return shape.body != nullptr; })) return pieces;
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

namespace {

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
            const double whole = weights[n], share = share_of_disc(piece, row.s[n], away, -outward.dot(tangent), slope);
            weights[n] *= share;
            if (slope != 0.0)
                add_change_of_share(piece, surface, row.points.at(i), tangent, outward,
                                    0.125 * whole * seventh(overlap) * overlap * slope * piece.radius, sum);
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
