#include "shapes/clearance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace porepack::shapes {

bool blocked(const std::vector<Capsule>& capsules, const Vec3& p, const Vec3& q) {
    const double length = (q - p).norm();
    if (length == 0.0) return false;
    const Vec3 direction = (q - p) / length;
    for (const auto& capsule : capsules)
        if (const auto inside = line_interval(capsule, p, direction))
            if (inside->high > 0.0 && inside->low < length * (1.0 - 1e-9)) return true;
    return false;
}

double clearance(const std::vector<Capsule>& capsules, const Vec3& origin, const Vec3& direction, double far) {
    double smallest = 1e300;
    const Capsule ray{origin, origin + far * direction, 0.0};
    for (const auto& capsule : capsules) smallest = std::min(smallest, gap(ray, capsule));
    return smallest;
}

namespace {

// Finds the direction of maximum clearance by a shrinking pattern search; stops early when the ray is free.
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

}  // namespace

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

Vec3 wider_place(const std::vector<Capsule>& capsules, const Vec3& point) {
    const double here = signed_distance(capsules, point);
    double largest = here * 1.001;
    Vec3 best = point;
    for (int k = 0; k < 27; ++k) {
        if (k == 13) continue;
        const Vec3 trial = point + 0.9 * here * Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).cast<double>().normalized();
        const double value = signed_distance(capsules, trial);
        if (value > largest) {
            largest = value;
            best = trial;
        }
    }
    return best;
}

}  // namespace porepack::shapes
