#include "packing/structure.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "shapes/segments.hpp"

namespace porepack::packing {
using namespace shapes;
using namespace vessels;
namespace {

constexpr std::size_t random_points = 4000;

// The vector between two points, to the nearest periodic image.
Vec3 apart(const Container& container, const Vec3& from, const Vec3& to) {
    Vec3 step = to - from;
    for (int axis = 0; axis < 3; ++axis)
        if (container.periodic()[static_cast<std::size_t>(axis)])
            step[axis] -= container.size()[axis] * std::round(step[axis] / container.size()[axis]);
    return step;
}

struct Grain {
    PlacedShape placed;
    Vec3 centre;
    std::vector<Capsule> capsules;
    double radius;  // of the sphere about the centre that holds it
};

std::vector<Grain> grains_of(const Packing& packing) {
    std::vector<ShapeMeasures> measures;
    for (const Shape& shape : packing.shapes) measures.push_back(measure(shape, 1e-5));
    std::vector<Grain> grains;
    for (const Body& body : packing.bodies) {
        const ShapeMeasures& of = measures[body.shape];
        grains.push_back({placed(packing, body), body.position_m + body.orientation * of.centre_of_mass_m, world_capsules(packing, body),
                          of.bounding_radius_m});
    }
    return grains;
}

// visit(i, j, vector from i to j) for all pairs nearer than `reach`; sorted by height where that is no periodic direction.
template <typename Visit>
void for_pairs(const Container& container, const std::vector<Vec3>& centres, double reach, const Visit& visit) {
    std::vector<std::size_t> order(centres.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return centres[i].z() < centres[j].z(); });
    for (std::size_t n = 0; n < order.size(); ++n)
        for (std::size_t m = n + 1; m < order.size(); ++m) {
            if (!container.periodic()[2] && centres[order[m]].z() - centres[order[n]].z() > reach) break;
            const Vec3 step = apart(container, centres[order[n]], centres[order[m]]);
            if (step.squaredNorm() < reach * reach) visit(order[n], order[m], step);
        }
}

Eigen::Matrix3d mean_of(const Eigen::Matrix3d& sum) {
    const double trace = sum.trace();
    return trace > 0.0 ? Eigen::Matrix3d(sum / trace) : Eigen::Matrix3d::Zero();
}

void find_contacts(const Container& container, const std::vector<Grain>& grains, const std::vector<Vec3>& centres, double contact_gap_m,
                   Structure& found) {
    double largest = 0.0;
    for (const Grain& grain : grains) largest = std::max(largest, grain.radius);
    std::vector<long>& neighbours = found.neighbours;
    neighbours.assign(grains.size(), 0);
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    for_pairs(container, centres, 2.0 * largest + contact_gap_m, [&](std::size_t i, std::size_t j, const Vec3& step) {
        const Vec3 shift = step - (centres[j] - centres[i]);
        bool touch = false;
        if (grains[i].placed.shape.body != nullptr || grains[j].placed.shape.body != nullptr) {
            PlacedShape other = grains[j].placed;
            other.position_m += shift;
            if (const Nearest place = nearest(grains[i].placed, other, 2.0 * contact_gap_m + 1e-12 * largest);
                place.gap_m <= contact_gap_m) {
                normals += place.normal * place.normal.transpose();
                ++found.contact_points;
                touch = true;
            }
        }
        for (const Capsule& one : grains[i].capsules)
            for (Capsule other : grains[j].capsules) {
                other.a += shift;
                other.b += shift;
                if (gap(one, other) > contact_gap_m) continue;
                const ClosestPoints closest = closest_points({one.a, one.b - one.a}, {other.a, other.b - other.a});
                const Vec3 normal = (closest.on_second - closest.on_first).normalized();
                normals += normal * normal.transpose();
                ++found.contact_points;
                touch = true;
            }
        if (!touch) return;
        ++neighbours[i];
        ++neighbours[j];
    });
    found.contact_orientation = mean_of(normals);
    for (const long count : neighbours) {
        found.grains_with_neighbours.resize(std::max(found.grains_with_neighbours.size(), static_cast<std::size_t>(count) + 1), 0);
        ++found.grains_with_neighbours[static_cast<std::size_t>(count)];
        found.mean_neighbours += static_cast<double>(count) / static_cast<double>(grains.size());
    }
}

std::vector<double> pairs_in_bins(const Container& container, const std::vector<Vec3>& points, double range_m, long bins) {
    std::vector<double> counts(static_cast<std::size_t>(bins), 0.0);
    for_pairs(container, points, range_m, [&](std::size_t, std::size_t, const Vec3& step) {
        counts[std::min(counts.size() - 1, static_cast<std::size_t>(step.norm() / range_m * static_cast<double>(bins)))] += 1.0;
    });
    const auto n = static_cast<double>(points.size());
    for (double& count : counts) count /= 0.5 * n * (n - 1.0);
    return counts;
}

// With the same distributions of the distances from walls and floor as the centres, but without any order between grains: each coordinate
// across walls is that of a centre chosen at random (between round walls the radius), the others are uniform.
std::vector<Vec3> random_points_like(const Container& container, const std::vector<Vec3>& centres) {
    std::mt19937_64 random(1);
    const auto uniform = [&](double from, double to) { return from + (to - from) * static_cast<double>(random() >> 11) * 0x1p-53; };
    const auto any = [&]() -> const Vec3& { return centres[random() % centres.size()]; };
    const auto walls = container.vessel().walls();
    const bool round = walls && !walls->round.empty();
    std::vector<Vec3> points(random_points);
    for (Vec3& point : points) {
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = container.periodic()[static_cast<std::size_t>(axis)] ? uniform(0.0, container.size()[axis]) : any()[axis];
        if (!round) continue;
        // At the radius of a grain, all around; where plane sides leave a sector, within it.
        constexpr int tries = 1000;
        for (int n = 0; n < tries; ++n) {
            const double radius = any().head<2>().norm(), angle = uniform(0.0, 2.0 * std::numbers::pi);
            point.head<2>() = radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
            if (container.wall_distance(point) >= 0.0) break;
        }
    }
    return points;
}

// The axis of a body: that whose moment of inertia differs from two that are equal; where all differ, that of the smallest moment. Zero:
// none, as of a cube. As long as the body.
Vec3 axis_of(const Shape& shape) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(measure(shape).inertia_per_density_m5);
    const Vec3 moments = solver.eigenvalues();
    const double equal = 1e-6 * moments[2];
    if (moments[2] - moments[0] < equal) return Vec3::Zero();
    return maximum_feret_diameter(shape) * solver.eigenvectors().col(moments[1] - moments[0] < equal ? 2 : 0);
}

// Of one grain.
Eigen::Matrix3d axes_of(const std::vector<Capsule>& capsules) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Capsule& capsule : capsules)
        if (const Vec3 axis = capsule.b - capsule.a; axis.norm() > 0.0) sum += axis * axis.transpose() / axis.norm();
    return sum;
}

// Tetrapods, tetrahedra and stars are isotropic in this measure, however they lie.
bool shows_orientation(const Packing& packing, const std::vector<Vec3>& axes_of_bodies) {
    for (std::size_t s = 0; s < packing.shapes.size(); ++s) {
        const Eigen::Matrix3d sum = axes_of(packing.shapes[s].capsules);
        if (axes_of_bodies[s] != Vec3::Zero()) return true;
        if ((sum - sum.trace() / 3.0 * Eigen::Matrix3d::Identity()).norm() > 1e-6 * sum.norm()) return true;
    }
    return false;
}

}  // namespace

Structure structure_of(const Packing& packing, double contact_gap_m, double range_m, long bins) {
    Structure found;
    Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
    const std::vector<Grain> grains = grains_of(packing);
    std::vector<Vec3> centres;
    std::vector<Vec3> of_bodies;
    for (const Shape& shape : packing.shapes) of_bodies.push_back(shape.body != nullptr ? axis_of(shape) : Vec3(Vec3::Zero()));
    for (std::size_t i = 0; i < grains.size(); ++i) {
        centres.push_back(grains[i].centre);
        axes += axes_of(grains[i].capsules);
        const Vec3 axis = packing.bodies[i].orientation * of_bodies[packing.bodies[i].shape];
        if (axis.norm() > 0.0) axes += axis * axis.transpose() / axis.norm();
    }
    if (shows_orientation(packing, of_bodies)) found.orientation = mean_of(axes);
    find_contacts(packing.container, grains, centres, contact_gap_m, found);
    if (grains.size() < 2) return found;
    const Container& container = packing.container;
    const std::vector<double> pairs = pairs_in_bins(container, centres, range_m, bins),
                              random = pairs_in_bins(container, random_points_like(container, centres), range_m, bins);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const double width = range_m / static_cast<double>(bins), r0 = width * static_cast<double>(i);
        found.radial_distribution.push_back({r0, r0 + width, random[i] > 0.0 ? pairs[i] / random[i] : std::nan("")});
    }
    return found;
}

std::vector<bool> whole_grains(const Packing& packing) {
    std::vector<bool> whole;
    for (const Body& body : packing.bodies) {
        const Bounds bounds = bounds_of(placed(packing, body));
        whole.push_back(!packing.container.cut_ends() || (bounds.low.z() >= 0.0 && bounds.high.z() <= packing.container.height()));
    }
    return whole;
}

}  // namespace porepack::packing
