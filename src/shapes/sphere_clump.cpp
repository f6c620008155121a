#include "shapes/sphere_clump.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.hpp"

namespace porepack::shapes {
namespace {

struct PointToCover {
    Vec3 place, outward;
};

// Where lines along the three axes enter and leave the body: of any part of the surface, one of the three meets it at 55 degrees or less.
// The lines of each axis lie `spacing` apart, the first at the share `start` of it.
std::vector<PointToCover> points_by_lines(const Shape& shape, double spacing, double start) {
    const RoundedBody& body = *shape.body;
    std::vector<PointToCover> points;
    std::vector<Interval> parts;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 along = Vec3::Unit(axis), first = Vec3::Unit((axis + 1) % 3), second = Vec3::Unit((axis + 2) % 3);
        const double u0 = -body.support(-first), u1 = body.support(first), v0 = -body.support(-second), v1 = body.support(second);
        for (double u = u0 + start * spacing; u < u1; u += spacing)
            for (double v = v0 + start * spacing; v < v1; v += spacing) {
                const Vec3 origin = u * first + v * second;
                body.line(origin, along, 0.0, parts);
                for (const Interval& part : parts)
                    for (const double t : {part.low, part.high}) {
                        PointToCover point{.place = origin + t * along, .outward = Vec3::Zero()};
                        (void)body.distance(point.place, &point.outward);
                        points.push_back(point);
                    }
            }
    }
    return points;
}

std::vector<PointToCover> points_by_number(const Shape& shape, double wanted, double start) {
    // By Cauchy's formula area / (4 spacing^2) lines of each axis meet a convex body of this area, on average, each of them twice.
    const double area = measure(shape, 1e-4).surface_area_m2;
    return points_by_lines(shape, std::sqrt(1.5 * area / wanted), start);
}

// As many that they lie nearer to each other than the tolerance, within limits.
double points_for(const Shape& shape, double tolerance) {
    return std::clamp(2.0 * measure(shape, 1e-4).surface_area_m2 / (tolerance * tolerance), 6000.0, 40000.0);
}

// The largest ball inside that touches the surface there.
Capsule ball_at(const RoundedBody& body, const PointToCover& point, double largest) {
    double low = 0.0, high = largest;
    for (int halving = 0; halving < 30; ++halving) {
        const double middle = 0.5 * (low + high);
        // Depths are those of the body's surface or less, so that no ball reaches out of it.
        (body.distance(point.place - middle * point.outward) <= -middle * (1.0 - 1e-9) ? low : high) = middle;
    }
    const Vec3 centre = point.place - low * point.outward;
    return {centre, centre, low};
}

class Cover {
public:
    Cover(const Shape& shape, double points)
        : body_(*shape.body), largest_(0.5 * body_.maximum_feret_diameter()), points_(points_by_number(shape, points, 0.5)) {
        constexpr std::size_t max_balls = 4000;
        const std::size_t step = 1 + points_.size() / max_balls;
        for (std::size_t i = 0; i < points_.size(); i += step) balls_.push_back(ball_at(body_, points_[i], largest_));
    }

    [[nodiscard]] std::vector<Capsule> clump(double tolerance) const {
        const auto covers = [&](const Capsule& ball, std::size_t i) {
            return (points_[i].place - ball.a).squaredNorm() <= std::pow(ball.radius + tolerance, 2);
        };
        std::vector<std::vector<int>> covered_by(points_.size());
        std::vector<long> gain(balls_.size(), 0);
        for (std::size_t b = 0; b < balls_.size(); ++b)
            for (std::size_t i = 0; i < points_.size(); ++i)
                if (covers(balls_[b], i)) {
                    covered_by[i].push_back(static_cast<int>(b));
                    ++gain[b];
                }
        std::vector<char> done(points_.size(), 0);
        std::vector<Capsule> spheres;
        const auto take = [&](const Capsule& ball) {
            spheres.push_back(ball);
            for (std::size_t i = 0; i < points_.size(); ++i)
                if (!done[i] && covers(ball, i)) {
                    done[i] = 1;
                    for (const int b : covered_by[i]) --gain[static_cast<std::size_t>(b)];
                }
        };
        while (true) {
            const auto best = std::max_element(gain.begin(), gain.end());
            if (*best <= 0) break;
            take(balls_[static_cast<std::size_t>(best - gain.begin())]);
        }
        // Points that no ball of the others covers have one of their own.
        for (std::size_t i = 0; i < points_.size(); ++i)
            if (!done[i]) take(ball_at(body_, points_[i], largest_));
        return spheres;
    }

private:
    const RoundedBody& body_;
    double largest_;  // radius
    std::vector<PointToCover> points_;
    std::vector<Capsule> balls_;  // candidates
};

std::vector<Capsule> along_axes(const Shape& shape, double tolerance) {
    std::vector<Capsule> spheres;
    const auto add_once = [&](const Vec3& centre, double radius) {
        for (const auto& sphere : spheres)
            if ((sphere.a - centre).norm() < 1e-6 * radius && std::abs(sphere.radius - radius) < 1e-6 * radius) return;
        spheres.push_back({centre, centre, radius});
    };
    for (const auto& capsule : shape.capsules) {
        const double r = capsule.radius;
        if (tolerance >= r)
            throw UserError("the clump's surface tolerance must be smaller than the capsule's radius",
                            {.where = "clump_tolerance", .allowed = fmt::format("less than {:g} m", r)});
        // Neighbouring spheres meet in a circle of radius r - tolerance, half a spacing from their centres.
        const double spacing = 2.0 * std::sqrt(r * r - (r - tolerance) * (r - tolerance));
        const double length = (capsule.b - capsule.a).norm();
        const int pieces = std::max(1, static_cast<int>(std::ceil(length / spacing - 1e-9)));
        for (int i = 0; i <= pieces; ++i) add_once(capsule.a + (capsule.b - capsule.a) * (static_cast<double>(i) / pieces), r);
    }
    return spheres;
}

}  // namespace

std::vector<Capsule> sphere_clump(const Shape& shape, double tolerance) {
    if (shape.body == nullptr) return along_axes(shape, tolerance);
    if (!(tolerance > 0.0 && tolerance < 0.5 * shape.body->thickness()))
        throw UserError("the clump's surface tolerance must be smaller than half the grain's thickness");
    return Cover(shape, points_for(shape, tolerance)).clump(tolerance);
}

SphereClump clump_of_at_most(const Shape& shape, long spheres) {
    const double d = smallest_diameter(shape);
    double fine = 0.0005 * d, coarse = 0.4 * d;  // the range of surface_tolerance
    std::optional<Cover> cover;
    if (shape.body != nullptr) cover.emplace(shape, 10000.0);
    const auto clump = [&](double tolerance) { return cover ? cover->clump(tolerance) : along_axes(shape, tolerance); };
    SphereClump found{.spheres = clump(coarse), .tolerance_m = coarse};
    if (found.spheres.size() > static_cast<std::size_t>(spheres))
        throw UserError(fmt::format("no clump of {} spheres lies within {:g} of the thickness below the surface of `{}`", spheres,
                                    coarse / d, shape.id),
                        {.where = "clump_spheres", .allowed = fmt::format("{} or more", found.spheres.size())});
    while (coarse > 1.02 * fine) {
        const double middle = std::sqrt(fine * coarse);
        std::vector<Capsule> trial = clump(middle);
        const bool few_enough = trial.size() <= static_cast<std::size_t>(spheres);
        (few_enough ? coarse : fine) = middle;
        if (few_enough) found = {.spheres = std::move(trial), .tolerance_m = middle};
    }
    return found;
}

std::vector<Capsule> with_volume(std::vector<Capsule> spheres, double volume_m3) {
    constexpr int max_steps = 8;
    for (int step = 0; step < max_steps; ++step) {
        const ShapeMeasures union_of = measure({.id = "clump", .capsules = spheres}, 1e-4, Effort::once);
        const double missing = volume_m3 - union_of.volume_m3;
        if (std::abs(missing) < 1e-3 * volume_m3) break;
        const double growth = missing / union_of.surface_area_m2;
        for (Capsule& sphere : spheres) sphere.radius += growth;
    }
    return spheres;
}

double clump_error(const Shape& shape, const std::vector<Capsule>& spheres) {
    double largest = 0.0;
    for (const PointToCover& point : points_by_number(shape, 20000.0, 0.31)) {
        double nearest = 1e300;
        for (const Capsule& sphere : spheres) nearest = std::min(nearest, (point.place - sphere.a).norm() - sphere.radius);
        largest = std::max(largest, std::abs(nearest));
    }
    return largest;
}

}  // namespace porepack::shapes
