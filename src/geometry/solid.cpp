#include "geometry/solid.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace porepack::inline geometry {
using core::Interval;

void unite(std::vector<Interval>& parts) {
    std::sort(parts.begin(), parts.end(), [](const Interval& p, const Interval& q) { return p.low < q.low; });
    std::size_t last = 0;
    for (std::size_t i = 1; i < parts.size(); ++i) {
        if (parts[i].low <= parts[last].high)
            parts[last].high = std::max(parts[last].high, parts[i].high);
        else
            parts[++last] = parts[i];
    }
    if (!parts.empty()) parts.resize(last + 1);
}

void Solid::near_column(double, double, double length, std::vector<Interval>& parts) const {
    const Bounds box = bounds();
    parts = {{box.low.z() - length, box.high.z() + length}};
}

bool Solid::contains(const Vec3& point) const {
    thread_local std::vector<Interval> parts;
    column(point.x(), point.y(), parts);
    return geometry::contains(parts, point.z());
}

bool contains(const std::vector<Interval>& parts, double z) {
    return std::any_of(parts.begin(), parts.end(), [z](const Interval& part) { return part.low <= z && z <= part.high; });
}

bool is_whole_line(const std::vector<Interval>& parts) {
    constexpr double endless = std::numeric_limits<double>::infinity();
    return parts.size() == 1 && parts[0] == Interval{-endless, endless};
}

void intersect(std::vector<Interval>& parts, const std::vector<Interval>& others) {
    std::vector<Interval> common;
    for (std::size_t p = 0, o = 0; p < parts.size() && o < others.size();) {
        const double low = std::max(parts[p].low, others[o].low), high = std::min(parts[p].high, others[o].high);
        if (low < high) common.push_back({low, high});
        parts[p].high < others[o].high ? ++p : ++o;
    }
    parts = std::move(common);
}

}  // namespace porepack::inline geometry
