#include "vessels/cone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"

namespace porepack::vessels {

Cone::Cone(double diameter_m, double top_diameter_m, double height_m)
    : floor_(diameter_m / 2.0), top_(top_diameter_m / 2.0), slope_((top_ - floor_) / height_m), height_(height_m) {
    if (top_ == floor_)
        throw UserError("a cone's diameters at the floor and at the top are equal", {.where = "[container]", .fix = "kind = \"cylinder\""});
}

Json Cone::to_json() const {
    return {{"kind", "cone"}, {"diameter_m", 2.0 * floor_}, {"top_diameter_m", 2.0 * top_}, {"height_m", height_}};
}

Bounds Cone::bounds() const {
    const double widest = std::max(floor_, top_);
    return {Vec3(-widest, -widest, 0.0), Vec3(widest, widest, height_)};
}

void Cone::column(double x, double y, std::vector<Interval>& parts) const {
    constexpr double endless = std::numeric_limits<double>::infinity();
    const double level = (std::hypot(x, y) - floor_) / slope_;
    parts.assign(1, slope_ > 0.0 ? Interval{level, endless} : Interval{-endless, level});
}

// |p + t s|^2 = R(z + t s_z)^2 is a t^2 + 2 half_b t + c = 0 with c <= 0 inside. Of the two forms of its root, that without a difference. A
// segment that is steeper than the cone (a < 0) leaves it only where it runs outward.
std::optional<double> Cone::first_hit(const Vec3& from, const Vec3& step) const {
    const double r = radius(from.z()), dr = slope_ * step.z();
    const double a = step.head<2>().squaredNorm() - dr * dr, half_b = from.head<2>().dot(step.head<2>()) - r * dr,
                 c = std::min(0.0, from.head<2>().squaredNorm() - r * r), root = half_b * half_b - a * c;
    if (root < 0.0 || (half_b <= 0.0 && a <= 0.0)) return std::nullopt;
    const double first = half_b > 0.0 ? -c / (half_b + std::sqrt(root)) : (std::sqrt(root) - half_b) / a;
    return first <= 1.0 ? std::optional(first) : std::nullopt;
}

double Cone::distance(const Vec3& point) const {
    return (radius(point.z()) - std::hypot(point.x(), point.y())) / std::hypot(1.0, slope_);
}

double Cone::mean_area(const Interval& heights) const {
    const double r = radius(heights.low), s = radius(heights.high);
    return std::numbers::pi * (r * r + r * s + s * s) / 3.0;
}

double Cone::side_per_volume() const {
    return std::numbers::pi * (floor_ + top_) * std::hypot(1.0, slope_) / mean_area({0.0, height_});
}

std::optional<VesselWalls> Cone::walls() const {
    return VesselWalls{.planes = {}, .round = {{.radius_m = floor_, .slope = slope_}}};
}

}  // namespace porepack::vessels
