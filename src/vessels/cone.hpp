// An upright cone with a flat floor: a frustum, wider or narrower at the top.
#pragma once

#include <optional>
#include <vector>

#include "geometry/vessel.hpp"

namespace porepack::vessels {

/// Axis at x = y = 0, floor at z = 0.
class Cone : public geometry::Vessel {
public:
    /// `diameter_m` at the floor. Throws UserError where both diameters are equal.
    Cone(double diameter_m, double top_diameter_m, double height_m);
    [[nodiscard]] core::Json to_json() const override;
    [[nodiscard]] geometry::Bounds bounds() const override;
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] std::optional<double> first_hit(const geometry::Vec3& from, const geometry::Vec3& step) const override;
    [[nodiscard]] double distance(const geometry::Vec3& point) const override;
    [[nodiscard]] double mean_area(const core::Interval& heights) const override;
    [[nodiscard]] double side_per_volume() const override;
    [[nodiscard]] std::optional<geometry::VesselWalls> walls() const override;

private:
    [[nodiscard]] double radius(double z) const { return floor_ + slope_ * z; }
    double floor_, top_, slope_, height_;  // radii; growth of the radius with the height
};

}  // namespace porepack::vessels
