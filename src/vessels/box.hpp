// A box, whose sides may be periodic.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/vessel.hpp"

namespace porepack::vessels {

/// One corner at the origin, edges along the axes.
class Box : public geometry::Vessel {
public:
    explicit Box(const geometry::Vec3& size_m, const std::array<bool, 3>& periodic = {false, false, false})
        : size_(size_m), periodic_(periodic) {}
    [[nodiscard]] core::Json to_json() const override;
    [[nodiscard]] geometry::Bounds bounds() const override { return {geometry::Vec3::Zero(), size_}; }
    [[nodiscard]] std::array<bool, 3> periodic() const override { return periodic_; }
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] std::optional<double> first_hit(const geometry::Vec3& from, const geometry::Vec3& step) const override;
    [[nodiscard]] double distance(const geometry::Vec3& point) const override;
    [[nodiscard]] double mean_area(const core::Interval&) const override { return size_.x() * size_.y(); }
    [[nodiscard]] double side_per_volume() const override;
    [[nodiscard]] bool fills_bounds() const override { return true; }
    [[nodiscard]] std::optional<geometry::VesselWalls> walls() const override;
    [[nodiscard]] std::vector<std::vector<std::array<double, 2>>> outlines(double deviation_m) const override;
    [[nodiscard]] std::shared_ptr<const Vessel> resized(const geometry::Vec3& size_m) const override;

private:
    geometry::Vec3 size_;
    std::array<bool, 3> periodic_;
};

}  // namespace porepack::vessels
