#include "vessels/box.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/json.hpp"

namespace porepack::vessels {

Json Box::to_json() const {
    return {{"kind", "box"}, {"size_m", {size_.x(), size_.y(), size_.z()}}, {"periodic", periodic_}};
}

void Box::column(double x, double y, std::vector<Interval>& parts) const {
    constexpr double endless = std::numeric_limits<double>::infinity();
    parts.clear();
    if (x >= 0.0 && x <= size_.x() && y >= 0.0 && y <= size_.y()) parts.push_back({-endless, endless});
}

std::optional<double> Box::first_hit(const Vec3& from, const Vec3& step) const {
    double first = 2.0;
    for (int axis = 0; axis < 2; ++axis) {
        if (periodic_[static_cast<std::size_t>(axis)] || step[axis] == 0.0) continue;
        const double wall = step[axis] > 0.0 ? size_[axis] : 0.0;
        first = std::min(first, std::max(0.0, (wall - from[axis]) / step[axis]));
    }
    return first <= 1.0 ? std::optional(first) : std::nullopt;
}

double Box::distance(const Vec3& point) const {
    double nearest = 1e300;
    for (int axis = 0; axis < 2; ++axis)
        if (!periodic_[static_cast<std::size_t>(axis)]) nearest = std::min({nearest, point[axis], size_[axis] - point[axis]});
    return nearest;
}

double Box::side_per_volume() const {
    double sum = 0.0;
    for (int axis = 0; axis < 2; ++axis)
        if (!periodic_[static_cast<std::size_t>(axis)]) sum += 2.0 / size_[axis];
    return sum;
}

std::optional<VesselWalls> Box::walls() const {
    VesselWalls walls;
    for (int axis = 0; axis < 2; ++axis) {
        if (periodic_[static_cast<std::size_t>(axis)]) continue;
        walls.planes.push_back({Vec3::Unit(axis), 0.0});
        walls.planes.push_back({-Vec3::Unit(axis), -size_[axis]});
    }
    return walls;
}

std::vector<std::vector<std::array<double, 2>>> Box::outlines(double) const {
    return {{{0.0, 0.0}, {size_.x(), 0.0}, {size_.x(), size_.y()}, {0.0, size_.y()}}};
}

std::shared_ptr<const Vessel> Box::resized(const Vec3& size_m) const {
    return std::make_shared<const Box>(size_m, periodic_);
}

}  // namespace porepack::vessels
