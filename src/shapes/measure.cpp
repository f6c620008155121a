// Volume, area and moments of a union of capsules, by quadrature over its exposed surface (divergence theorem).
// A capsule's surface is swept by meridians: cap, side line, cap. On each meridian the exposed parts are found to rounding
// (the side lines in closed form), and each part is integrated by Gauss' rule; only the sum over the meridians is a
// quadrature with an error, of order 3/2 because of the kinks where a meridian touches another capsule.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "shapes/shape.hpp"

namespace porepack {
namespace {

constexpr int arc_samples = 48;

struct SurfacePoint {
    Vec3 x, normal;
    double area_per_parameter;  // per unit of the meridian's parameter and of the angle phi
};

// Integrals over the surface that give area, volume and the first and second moments.
struct Sums {
    double area = 0.0, volume = 0.0;
    Vec3 first = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

    void add(const Vec3& x, const Vec3& normal, double dA) {
        const Vec3 n = dA * normal;
        area += dA;
        volume += x.dot(n) / 3.0;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3;
            first[i] += x[i] * x[i] * n[i] / 2.0;
            second(i, i) += x[i] * x[i] * x[i] * n[i] / 3.0;
            second(i, j) += x[i] * x[i] * x[j] * n[i] / 2.0;
            second(j, i) = second(i, j);
        }
    }
    void add(const Sums& other) {
        area += other.area;
        volume += other.volume;
        first += other.first;
        second += other.second;
    }
};

// Where surfaces coincide (shared end spheres, collinear capsules), the capsule listed first owns them.
bool covered(const std::vector<Capsule>& capsules, std::size_t own, const Vec3& x, const Vec3& normal) {
    for (std::size_t j = 0; j < capsules.size(); ++j) {
        if (j == own) continue;
        const double tolerance = 1e-10 * capsules[j].radius;
        const Vec3 offset = x - closest_on_axis(capsules[j], x);
        const double s = offset.norm() - capsules[j].radius;
        if (s < -tolerance || (s <= tolerance && j < own && offset.dot(normal) > 0.5 * capsules[j].radius)) return true;
    }
    return false;
}

constexpr std::array<double, 8> gauss_node = {-0.9602898564975363, -0.7966664774136267, -0.5255324099163290, -0.1834346424956498,
                                              0.1834346424956498,  0.5255324099163290,  0.7966664774136267,  0.9602898564975363};
constexpr std::array<double, 8> gauss_weight = {0.1012285362903763, 0.2223810344533745, 0.3137066458778873, 0.3626837833783620,
                                                0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

class Surface {
public:
    Surface(const Shape& shape, const Vec3& about, int meridians) : shape_(shape), about_(about), meridians_(meridians) {}

    void integrate() {
        for (std::size_t own = 0; own < shape_.capsules.size(); ++own)
            for (int p = 0; p < meridians_; ++p) integrate_meridian(own, (p + 0.5) * 2.0 * std::numbers::pi / meridians_);
    }
    Sums outer, cavity;

private:
    void integrate_meridian(std::size_t own, double phi) {
        const Capsule& capsule = shape_.capsules[own];
        const double r = capsule.radius;
        const double length = (capsule.b - capsule.a).norm();
        const Vec3 axis = length > 0.0 ? Vec3((capsule.b - capsule.a) / length) : Vec3(Vec3::UnitZ());
        const Vec3 e1 = axis.unitOrthogonal();
        const Vec3 radial = std::cos(phi) * e1 + std::sin(phi) * axis.cross(e1);
        for (const double sign : {-1.0, 1.0}) {
            const Vec3 centre = sign > 0 ? capsule.b : capsule.a;
            const auto arc = [&](double theta) {
                const Vec3 normal = std::sin(theta) * radial + sign * std::cos(theta) * axis;
                return SurfacePoint{centre + r * normal, normal, r * r * std::sin(theta)};
            };
            integrate_arc(own, arc);
        }
        if (length > 0.0) {
            const auto line = [&](double t) { return SurfacePoint{capsule.a + t * axis + r * radial, radial, r}; };
            integrate_line(own, line, length, axis);
        }
    }

    template <typename Point>
    void integrate_arc(std::size_t own, const Point& point) {
        const auto is_covered = [&](double theta) {
            const SurfacePoint at = point(theta);
            return covered(shape_.capsules, own, at.x, at.normal);
        };
        const double end = std::numbers::pi / 2.0;
        // Crowded at both ends (Chebyshev points), where a neighbour may hide a sliver of the arc.
        const auto sample = [&](int k) {
            return std::clamp(0.5 * end * (1.0 - std::cos(std::numbers::pi * k / arc_samples)), 1e-9, end - 1e-9);
        };
        double start = 0.0;
        double before = sample(0);
        bool state = is_covered(before);
        for (int k = 1; k <= arc_samples; ++k) {
            const double here = sample(k);
            const bool now = is_covered(here);
            if (now != state) {
                double low = before, high = here;
                while (high - low > 1e-13) {
                    const double middle = 0.5 * (low + high);
                    (is_covered(middle) == state ? low : high) = middle;
                }
                if (!state) add_part(own, point, start, low);
                start = high;
                state = now;
            }
            before = here;
        }
        if (!state) add_part(own, point, start, end);
    }

    template <typename Point>
    void integrate_line(std::size_t own, const Point& point, double length, const Vec3& axis) {
        std::vector<Interval> hidden;
        const SurfacePoint start = point(0.0);
        for (std::size_t j = 0; j < shape_.capsules.size(); ++j) {
            if (j == own) continue;
            // A line on the very surface (collinear capsules, twice the same) is hidden by the capsule listed first: the other
            // is taken thicker by a hair to find such a touch, and asked in the middle whether it is one.
            Capsule other = shape_.capsules[j];
            other.radius *= 1.0 + 1e-12;
            const auto inside = line_interval(other, start.x, axis);
            if (!inside) continue;
            const double middle = std::clamp(0.5 * (inside->low + inside->high), 0.0, length);
            if (j < own || signed_distance(shape_.capsules[j], point(middle).x) < -1e-10 * other.radius) hidden.push_back(*inside);
        }
        std::sort(hidden.begin(), hidden.end(), [](const Interval& p, const Interval& q) { return p.low < q.low; });
        double at = 0.0;
        for (const auto& part : hidden) {
            if (part.low > at) add_part(own, point, at, std::min(part.low, length));
            at = std::max(at, part.high);
        }
        if (at < length) add_part(own, point, at, length);
    }

    // An exposed part is one connected piece of the surface, so it lies in a cavity as a whole or not at all.
    template <typename Point>
    void add_part(std::size_t own, const Point& point, double low, double high) {
        if (high <= low) return;
        const SurfacePoint middle = point(0.5 * (low + high));
        const bool inner =
            !shape_.cavity_points.empty() && in_cavity(shape_, middle.x + 1e-7 * shape_.capsules[own].radius * middle.normal);
        Sums& sums = inner ? cavity : outer;
        const double half = 0.5 * (high - low);
        for (std::size_t g = 0; g < gauss_node.size(); ++g) {
            const SurfacePoint at = point(0.5 * (low + high) + half * gauss_node[g]);
            sums.add(at.x - about_, at.normal, at.area_per_parameter * half * gauss_weight[g] * 2.0 * std::numbers::pi / meridians_);
        }
    }

    const Shape& shape_;
    Vec3 about_;
    int meridians_;
};

}  // namespace

ShapeMeasures measure(const Shape& shape, int meridians) {
    const Bounds bounds = bounds_of(shape.capsules);
    const Vec3 about = 0.5 * (bounds.low + bounds.high);
    double cavity_volume = 0.0;
    const auto sums_at = [&](int n) {
        Surface surface(shape, about, n);
        surface.integrate();
        cavity_volume = std::max(0.0, -surface.cavity.volume);  // its outward normal points into the void
        if (shape.cavity == Cavity::open) surface.outer.add(surface.cavity);
        return surface.outer;
    };
    const Sums coarse = sums_at(meridians / 2);
    const Sums fine = sums_at(meridians);

    ShapeMeasures measures;
    measures.volume_m3 = fine.volume;
    measures.surface_area_m2 = fine.area;
    measures.cavity_volume_m3 = cavity_volume;
    const Vec3 centre = fine.first / fine.volume;
    measures.centre_of_mass_m = about + centre;
    const Eigen::Matrix3d second = fine.second - fine.volume * centre * centre.transpose();
    measures.inertia_per_density_m5 = second.trace() * Eigen::Matrix3d::Identity() - second;
    measures.sphericity = std::cbrt(36.0 * std::numbers::pi * fine.volume * fine.volume) / fine.area;
    for (const auto& capsule : shape.capsules)
        for (const Vec3& end : {capsule.a, capsule.b})
            measures.bounding_radius_m = std::max(measures.bounding_radius_m, (end - measures.centre_of_mass_m).norm() + capsule.radius);
    measures.span_m = span(shape);
    measures.relative_error = std::max(std::abs(fine.volume / coarse.volume - 1.0), std::abs(fine.area / coarse.area - 1.0));
    return measures;
}

}  // namespace porepack
