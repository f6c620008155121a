// Enclosed voids of a union of capsules.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "shapes/shape.hpp"

namespace porepack {
namespace {

constexpr int cells = 48;

// Does the segment from p to q pass through a capsule?
bool blocked(const std::vector<Capsule>& capsules, const Vec3& p, const Vec3& q) {
    const double length = (q - p).norm();
    if (length == 0.0) return false;
    const Vec3 direction = (q - p) / length;
    for (const auto& capsule : capsules)
        if (const auto inside = line_interval(capsule, p, direction))
            if (inside->high > 0.0 && inside->low < length * (1.0 - 1e-9)) return true;
    return false;
}

// Clearance of the ray from `origin`: its least distance to a surface, negative when it is blocked.
double clearance(const std::vector<Capsule>& capsules, const Vec3& origin, const Vec3& direction, double far) {
    double least = 1e300;
    const Capsule ray{origin, origin + far * direction, 0.0};
    for (const auto& capsule : capsules) least = std::min(least, gap(ray, capsule));
    return least;
}

// Climbs to the direction of the largest clearance by a shrinking pattern search; stops early once the ray is free.
double best_clearance(const std::vector<Capsule>& capsules, const Vec3& origin, Vec3 direction, double far) {
    double best = clearance(capsules, origin, direction, far);
    int moves = 0;
    for (double step = 0.1; step > 1e-7 && best <= 0.0 && moves < 200;) {
        const Vec3 e1 = direction.unitOrthogonal();
        const Vec3 e2 = direction.cross(e1);
        Vec3 better = direction;
        for (int k = 0; k < 6; ++k) {
            const double angle = std::numbers::pi * k / 3.0;
            const Vec3 trial = (direction + step * (std::cos(angle) * e1 + std::sin(angle) * e2)).normalized();
            const double value = clearance(capsules, origin, trial, far);
            if (value > best) {
                best = value;
                better = trial;
            }
        }
        if (better == direction)
            step *= 0.5;
        else
            ++moves;
        direction = better;
    }
    return best;
}

// Looks for a straight way out: the 24 most promising of 512 directions, each improved.
bool ray_escapes(const std::vector<Capsule>& capsules, const Vec3& origin, double far) {
    constexpr int starts = 512;
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    std::vector<std::pair<double, Vec3>> directions;
    for (int i = 0; i < starts; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / starts;
        const double rho = std::sqrt(1.0 - z * z);
        const Vec3 direction(rho * std::cos(golden * i), rho * std::sin(golden * i), z);
        directions.emplace_back(clearance(capsules, origin, direction, far), direction);
    }
    std::partial_sort(directions.begin(), directions.begin() + 24, directions.end(),
                      [](const auto& p, const auto& q) { return p.first > q.first; });
    return std::any_of(directions.begin(), directions.begin() + 24,
                       [&](const auto& start) { return best_clearance(capsules, origin, start.second, far) > 0.0; });
}

struct Grid {
    Vec3 origin;
    double size;
    std::vector<char> state;  // 0 solid, 1 void, 2 void reached from outside or dealt with
    static int index(int i, int j, int k) { return (k * cells + j) * cells + i; }
    [[nodiscard]] Vec3 centre(int cell) const {
        return origin + size * Vec3(cell % cells + 0.5, cell / cells % cells + 0.5, cell / (cells * cells) + 0.5);
    }
    void flood(int start) {
        std::vector<int> stack = {start};
        state[static_cast<std::size_t>(start)] = 2;
        while (!stack.empty()) {
            const int cell = stack.back();
            stack.pop_back();
            const std::array<int, 3> at = {cell % cells, cell / cells % cells, cell / (cells * cells)};
            for (int axis = 0; axis < 3; ++axis)
                for (int step : {-1, 1}) {
                    auto next = at;
                    next[static_cast<std::size_t>(axis)] += step;
                    if (next[static_cast<std::size_t>(axis)] < 0 || next[static_cast<std::size_t>(axis)] >= cells) continue;
                    const int there = index(next[0], next[1], next[2]);
                    if (state[static_cast<std::size_t>(there)] != 1) continue;
                    state[static_cast<std::size_t>(there)] = 2;
                    stack.push_back(there);
                }
        }
    }
};

Grid classify(const std::vector<Capsule>& capsules) {
    const Bounds bounds = bounds_of(capsules);
    const double extent = (bounds.high - bounds.low).maxCoeff();
    Grid grid{.origin = 0.5 * (bounds.low + bounds.high) - Vec3::Constant(0.55 * extent), .size = 1.1 * extent / cells, .state = {}};
    grid.state.resize(static_cast<std::size_t>(cells) * cells * cells);
    for (int cell = 0; cell < cells * cells * cells; ++cell)
        grid.state[static_cast<std::size_t>(cell)] = signed_distance(capsules, grid.centre(cell)) > 0.0 ? 1 : 0;
    return grid;
}

}  // namespace

void find_cavities(Shape& shape) {
    shape.cavity_points.clear();
    if (shape.capsules.size() < 3) return;  // the complement of two convex bodies is connected
    Grid grid = classify(shape.capsules);
    grid.flood(0);
    const double far = 4.0 * cells * grid.size;
    Vec3 middle = Vec3::Zero();
    for (const auto& capsule : shape.capsules) middle += (capsule.a + capsule.b) / (2.0 * static_cast<double>(shape.capsules.size()));

    // The middle first: a small cavity of a symmetric grain slips through the grid.
    std::vector<Vec3> candidates;
    if (signed_distance(shape.capsules, middle) > 0.0) candidates.push_back(middle);
    for (int cell = 0; cell < cells * cells * cells; ++cell)
        if (grid.state[static_cast<std::size_t>(cell)] == 1) candidates.push_back(grid.centre(cell));
    std::vector<Vec3> open;
    const auto seen_from = [&](const std::vector<Vec3>& points, const Vec3& point) {
        for (const auto& other : points)
            if (!blocked(shape.capsules, other, point)) return true;
        return false;
    };
    for (const auto& point : candidates) {
        if (seen_from(shape.cavity_points, point) || seen_from(open, point)) continue;
        (ray_escapes(shape.capsules, point, far) ? open : shape.cavity_points).push_back(point);
    }
}

bool in_cavity(const Shape& shape, const Vec3& point) {
    for (const auto& seed : shape.cavity_points)
        if (!blocked(shape.capsules, seed, point)) return true;
    return false;
}

}  // namespace porepack
