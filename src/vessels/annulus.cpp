#include "vessels/annulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "vessels/cylinder.hpp"

namespace porepack::vessels {

Annulus::Annulus(double inner_diameter_m, double diameter_m, double height_m)
    : inner_(inner_diameter_m / 2.0), outer_(diameter_m / 2.0), height_(height_m) {
    if (!(inner_ < outer_))
        throw UserError(
            fmt::format("the inner diameter of an annulus, {:g} m, is not below its outer one, {:g} m", inner_diameter_m, diameter_m),
            {.where = "[container]", .fix = "exchange inner_diameter_m and diameter_m, or give a cylinder"});
}

Json Annulus::to_json() const {
    return {{"kind", "annulus"}, {"inner_diameter_m", 2.0 * inner_}, {"diameter_m", 2.0 * outer_}, {"height_m", height_}};
}

Bounds Annulus::bounds() const {
    return {Vec3(-outer_, -outer_, 0.0), Vec3(outer_, outer_, height_)};
}

void Annulus::column(double x, double y, std::vector<Interval>& parts) const {
    constexpr double endless = std::numeric_limits<double>::infinity();
    parts.clear();
    if (const double square = x * x + y * y; square <= outer_ * outer_ && square >= inner_ * inner_) parts.push_back({-endless, endless});
}

// |p + t s| = R is a t^2 + 2 half_b t + c = 0; its larger t leaves the outer cylinder, the smaller one enters the inner one.
std::optional<double> Annulus::first_hit(const Vec3& from, const Vec3& step) const {
    const Eigen::Vector2d p = from.head<2>(), s = step.head<2>();
    const double a = s.squaredNorm(), half_b = p.dot(s);
    if (!(a > 0.0)) return std::nullopt;
    double first = 2.0;
    if (const double root = half_b * half_b - a * (p.squaredNorm() - inner_ * inner_); root > 0.0 && half_b < 0.0)
        first = std::max(0.0, (-half_b - std::sqrt(root)) / a);
    if (const double root = half_b * half_b - a * (p.squaredNorm() - outer_ * outer_); root >= 0.0)
        first = std::min(first, std::max(0.0, (std::sqrt(root) - half_b) / a));
    return first <= 1.0 ? std::optional(first) : std::nullopt;
}

double Annulus::distance(const Vec3& point) const {
    const double away = std::hypot(point.x(), point.y());
    return std::min(outer_ - away, away - inner_);
}

double Annulus::least_distance(const Vec3& a, const Vec3& b) const {
    const Eigen::Vector2d p = a.head<2>(), along = (b - a).head<2>();
    const double square = along.squaredNorm(), part = square > 0.0 ? std::clamp(-p.dot(along) / square, 0.0, 1.0) : 0.0;
    return std::min({distance(a), distance(b), (p + part * along).norm() - inner_});
}

double Annulus::mean_area(const Interval&) const {
    return std::numbers::pi * (outer_ * outer_ - inner_ * inner_);
}

std::optional<VesselWalls> Annulus::walls() const {
    return VesselWalls{.planes = {}, .round = {{.radius_m = outer_}, {.radius_m = inner_, .inside = true}}};
}

std::vector<std::vector<std::array<double, 2>>> Annulus::outlines(double deviation_m) const {
    auto hole = circle(inner_, deviation_m);
    std::reverse(hole.begin(), hole.end());
    return {circle(outer_, deviation_m), hole};
}

}  // namespace porepack::vessels
