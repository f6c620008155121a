// Some points side by side: arithmetic on all of them takes hardly longer than on one.
#pragma once

#include <array>
#include <cstddef>

#include "geometry/vector.hpp"

namespace porepack::shapes {

using geometry::Vec3;

using Row = std::array<double, 16>;

/// All sixteen have numbers; the first `count` mean something.
struct PointRow {
    static constexpr int most = 16;
    int count = 0;
    Row x, y, z;
    [[nodiscard]] Vec3 at(int i) const {
        const auto n = static_cast<std::size_t>(i);
        return {x[n], y[n], z[n]};
    }
    void set(int i, const Vec3& point) {
        const auto n = static_cast<std::size_t>(i);
        x[n] = point.x();
        y[n] = point.y();
        z[n] = point.z();
    }
};

/// Distances of points from a surface, and the directions in which they grow: unit vectors, where the point counts.
struct DistanceRow {
    Row distance;
    PointRow outward;
    void set(int i, double away, const Vec3& direction) {
        distance[static_cast<std::size_t>(i)] = away;
        outward.set(i, direction);
    }
    /// Of points that do not count.
    void clear_from(int count) {
        for (int i = count; i < PointRow::most; ++i) set(i, 0.0, Vec3::Zero());
    }
};

}  // namespace porepack::shapes
