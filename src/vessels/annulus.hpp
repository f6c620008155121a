// The space between two upright cylinders with one axis.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "geometry/vessel.hpp"

namespace porepack::vessels {

/// Axis at x = y = 0, floor at z = 0.
class Annulus : public geometry::Vessel {
public:
    /// Throws UserError unless the inner diameter is the smaller one.
    Annulus(double inner_diameter_m, double diameter_m, double height_m);
    [[nodiscard]] core::Json to_json() const override;
    [[nodiscard]] geometry::Bounds bounds() const override;
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] std::optional<double> first_hit(const geometry::Vec3& from, const geometry::Vec3& step) const override;
    [[nodiscard]] double distance(const geometry::Vec3& point) const override;
    [[nodiscard]] double least_distance(const geometry::Vec3& a, const geometry::Vec3& b) const override;
    [[nodiscard]] double mean_area(const core::Interval& heights) const override;
    [[nodiscard]] double side_per_volume() const override { return 2.0 / (outer_ - inner_); }
    [[nodiscard]] std::optional<geometry::VesselWalls> walls() const override;
    [[nodiscard]] std::vector<std::vector<std::array<double, 2>>> outlines(double deviation_m) const override;

private:
    double inner_, outer_, height_;  // radii
};

}  // namespace porepack::vessels
