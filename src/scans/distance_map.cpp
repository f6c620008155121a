#include "scans/distance_map.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/parallel.hpp"
#include "pores/pores.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {

double DistanceMap::at(const Vec3& point) const {
    std::array<int, 3> low{}, high{};
    std::array<double, 3> part{};
    for (std::size_t a = 0; a < 3; ++a) {
        const double x =
            std::clamp((point[static_cast<Eigen::Index>(a)] - grid.origin_m[a]) / grid.spacing_m[a] - 0.5, 0.0, grid.cells[a] - 1.0);
        low[a] = static_cast<int>(x);
        high[a] = std::min(low[a] + 1, grid.cells[a] - 1);
        part[a] = x - low[a];
    }
    const auto value = [&](int i, int j, int k) { return static_cast<double>(distance_m[grid.index(i, j, k)]); };
    const auto along_x = [&](int j, int k) { return value(low[0], j, k) + part[0] * (value(high[0], j, k) - value(low[0], j, k)); };
    const auto in_plane = [&](int k) { return along_x(low[1], k) + part[1] * (along_x(high[1], k) - along_x(low[1], k)); };
    return in_plane(low[2]) + part[2] * (in_plane(high[2]) - in_plane(low[2]));
}

DistanceMap distance_map(const GrayImage& image) {
    DistanceMap map{.grid = image.grid, .distance_m = {}};
    PhaseImage phases{.grid = image.grid, .phase = std::vector<std::uint8_t>(image.packed.size()), .notes = {}};
    const std::uint16_t level = GrayImage::pack(image.level);
    constexpr std::array<bool, 3> open = {false, false, false};
    // Two transforms with the phases exchanged: the first gives the distances in the pores, the second those in the solid.
    for (const bool solid : {false, true}) {
        for (std::size_t cell = 0; cell < phases.phase.size(); ++cell)
            phases.phase[cell] = (image.packed[cell] > level) == solid ? Phase::pore : Phase::grain;
        const std::vector<float> distance = pores::wall_distance_m(phases, open);
        if (!solid) {
            map.distance_m = distance;
            continue;
        }
        for (std::size_t cell = 0; cell < distance.size(); ++cell)
            if (distance[cell] > 0.0F) map.distance_m[cell] = -distance[cell];
    }
    return map;
}

double fit_to_surface(const DistanceMap& map, const ShapePoints& shape, Pose& pose) {
    // Levenberg-Marquardt on the map's distance at each point of the grain's surface. A rigid motion (t, w) moves a point by
    // t + w x offset, so the derivative of its distance is [slope, offset x slope]. Huber weights limit points that lie off the surface;
    // points beyond `clamped` cost a constant and have no weight in the step.
    const double h = map.grid.spacing_m[0], r = shape.thinnest_radius_m, clamped = 1.5 * r, huber = 0.3 * r;
    const double bottom = map.grid.origin_m[2], top = bottom + map.grid.cells[2] * h;
    const auto sums = [&](const Pose& at, StepMatrix* H, Step* g) {
        double cost = 0.0;
        long count = 0;
        for (const Vec3& point : shape.surface) {
            const Vec3 offset = at.orientation * point, x = at.position_m + offset;
            if (x.z() < bottom || x.z() > top) continue;
            const double distance = std::clamp(map.at(x), -clamped, clamped), size = std::abs(distance);
            const double weight = size > huber ? huber / size : 1.0;
            cost += size > huber ? huber * (2.0 * size - huber) : size * size;
            ++count;
            if (H == nullptr || size >= clamped) continue;
            Vec3 slope;
            for (int a = 0; a < 3; ++a) {
                Vec3 step = Vec3::Zero();
                step[a] = 0.7 * h;
                slope[a] = (map.at(x + step) - map.at(x - step)) / (1.4 * h);
            }
            Step J;
            J << slope, offset.cross(slope);
            *H += weight * J * J.transpose();
            *g += weight * distance * J;
        }
        return count > 0 ? cost / static_cast<double>(count) : 1e300;
    };
    double damping = 1e-2, cost = sums(pose, nullptr, nullptr);
    for (int iteration = 0; iteration < 40; ++iteration) {
        StepMatrix H = StepMatrix::Zero();
        Step g = Step::Zero();
        (void)sums(pose, &H, &g);
        bool better = false;
        for (int trial = 0; trial < 6 && !better; ++trial) {
            StepMatrix A = H;
            // Rotations about an axis of symmetry have no curvature: the floor keeps the matrix regular.
            const double floor = 1e-9 * H.diagonal().maxCoeff() + 1e-300;
            for (int d = 0; d < 6; ++d) A(d, d) += damping * H(d, d) + floor * (d < 3 ? 1.0 : r * r);
            Step step = -A.ldlt().solve(g);
            // No point moves much farther than a radius: beyond, the linearised distance is wrong.
            const double largest = std::max(step.head<3>().norm() / (0.5 * r), step.tail<3>().norm() * shape.reach_m / r);
            if (largest > 1.0) step /= largest;
            const Pose next = moved_by(pose, step);
            if (const double trial_cost = sums(next, nullptr, nullptr); trial_cost < cost) {
                better = largest > 0.0;
                const bool small = cost - trial_cost < 1e-4 * cost;
                cost = trial_cost;
                pose = next;
                damping = std::max(1e-4, 0.3 * damping);
                if (small) return cost;
            } else {
                damping *= 8.0;
            }
        }
        if (!better) return cost;
    }
    return cost;
}

}  // namespace porepack::scans
