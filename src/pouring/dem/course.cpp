#include "pouring/dem/course.hpp"

#include <algorithm>
#include <cmath>

#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

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

}  // namespace

Course::Course(const ContactPiece& piece, const Surface& surface) : piece_(piece), surface_(surface) {
    row_.points.count = PointRow::most;
    for (std::size_t i = 0; i < samples; ++i) row_.s[i] = static_cast<double>(i) / (samples - 1);
    place(piece, row_);
    surface.distances(row_.points, found_);
    // From one point to another, the distance changes by no more than the way.
    bound_ = bound_between(row_, found_.distance);
}

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

}  // namespace porepack::pouring::dem
