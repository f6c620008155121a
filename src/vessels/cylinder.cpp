#include "vessels/cylinder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "core/json.hpp"

namespace porepack::vessels {

Json Cylinder::to_json() const {
    return {{"kind", "cylinder"}, {"diameter_m", diameter_}, {"height_m", height_}};
}

Bounds Cylinder::bounds() const {
    return {Vec3(-diameter_ / 2.0, -diameter_ / 2.0, 0.0), Vec3(diameter_ / 2.0, diameter_ / 2.0, height_)};
}

void Cylinder::column(double x, double y, std::vector<Interval>& parts) const {
    constexpr double endless = std::numeric_limits<double>::infinity();
    parts.clear();
    if (x * x + y * y <= diameter_ * diameter_ / 4.0) parts.push_back({-endless, endless});
}

// |p + t s| = D/2 is a t^2 + 2 half_b t + c = 0; its larger t leaves the cylinder.
std::optional<double> Cylinder::first_hit(const Vec3& from, const Vec3& step) const {
    const Eigen::Vector2d p = from.head<2>(), s = step.head<2>();
    const double a = s.squaredNorm(), half_b = p.dot(s), c = p.squaredNorm() - diameter_ * diameter_ / 4.0;
    const double root = half_b * half_b - a * c;
    if (!(a > 0.0 && root >= 0.0)) return std::nullopt;
    const double first = std::max(0.0, (std::sqrt(root) - half_b) / a);
    return first <= 1.0 ? std::optional(first) : std::nullopt;
}

double Cylinder::distance(const Vec3& point) const {
    return diameter_ / 2.0 - std::hypot(point.x(), point.y());
}

double Cylinder::mean_area(const Interval&) const {
    return std::numbers::pi * diameter_ * diameter_ / 4.0;
}

std::optional<VesselWalls> Cylinder::walls() const {
    return VesselWalls{.planes = {}, .round = {{.radius_m = diameter_ / 2.0}}};
}

std::vector<std::vector<std::array<double, 2>>> Cylinder::outlines(double deviation_m) const {
    return {circle(diameter_ / 2.0, deviation_m)};
}

std::vector<std::array<double, 2>> circle(double radius_m, double deviation_m) {
    const int n = std::max(24, static_cast<int>(std::ceil(std::numbers::pi / std::acos(1.0 - std::min(0.5, deviation_m / radius_m)))));
    const double step = 2.0 * std::numbers::pi / n;
    const double corner = radius_m * std::sqrt(step / std::sin(step));
    std::vector<std::array<double, 2>> corners;
    for (int i = 0; i < n; ++i) corners.push_back({corner * std::cos((i + 0.31) * step), corner * std::sin((i + 0.31) * step)});
    return corners;
}

std::shared_ptr<const Vessel> Cylinder::resized(const Vec3& size_m) const {
    if (size_m.x() != size_m.y()) return nullptr;
    return std::make_shared<const Cylinder>(size_m.x(), size_m.z());
}

}  // namespace porepack::vessels
