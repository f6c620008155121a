#include "geometry/vessel.hpp"

#include <cmath>

namespace porepack::inline geometry {

double VesselWalls::Round::overlap(const Vec3& centre, double radius) const {
    const double away = centre.head<2>().norm(), here = radius_m + slope * centre.z();
    if (inside) return here + radius - away;
    const double slant = std::sqrt(1.0 + slope * slope);
    return (away + radius * slant - here) / slant;
}

Vec3 VesselWalls::Round::normal(const Vec3& point) const {
    const double away = point.head<2>().norm();
    if (!(away > 0.0)) return Vec3::UnitX();
    const double slant = std::sqrt(1.0 + slope * slope), sign = inside ? 1.0 : -1.0;
    return {sign * point.x() / (away * slant), sign * point.y() / (away * slant), slope / slant};
}

bool VesselWalls::convex() const {
    return mesh == nullptr && std::none_of(round.begin(), round.end(), [](const Round& wall) { return wall.inside; });
}

}  // namespace porepack::inline geometry
