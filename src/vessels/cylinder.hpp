// An upright cylinder.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/vessel.hpp"

namespace porepack::vessels {

/// Axis at x = y = 0, floor at z = 0.
class Cylinder : public geometry::Vessel {
public:
    Cylinder(double diameter_m, double height_m) : diameter_(diameter_m), height_(height_m) {}
    [[nodiscard]] core::Json to_json() const override;
    [[nodiscard]] geometry::Bounds bounds() const override;
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] std::optional<double> first_hit(const geometry::Vec3& from, const geometry::Vec3& step) const override;
    [[nodiscard]] double distance(const geometry::Vec3& point) const override;
    [[nodiscard]] double mean_area(const core::Interval& heights) const override;
    [[nodiscard]] double side_per_volume() const override { return 4.0 / diameter_; }
    [[nodiscard]] std::optional<double> tube_diameter() const override { return diameter_; }
    [[nodiscard]] std::optional<geometry::VesselWalls> walls() const override;
    [[nodiscard]] std::vector<std::vector<std::array<double, 2>>> outlines(double deviation_m) const override;
    [[nodiscard]] std::shared_ptr<const Vessel> resized(const geometry::Vec3& size_m) const override;

private:
    double diameter_, height_;
};

/// Corners of a polygon of the circle's area, counter-clockwise, nowhere farther than `deviation_m` from it.
[[nodiscard]] std::vector<std::array<double, 2>> circle(double radius_m, double deviation_m);

}  // namespace porepack::vessels
