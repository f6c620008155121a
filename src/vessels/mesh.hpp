// A vessel given by the closed surface of its inner space.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/triangle_wall.hpp"
#include "geometry/vessel.hpp"

namespace porepack::vessels {

class MeshVessel : public geometry::Vessel {
public:
    /// Throws UserError where a TriangleWall does.
    explicit MeshVessel(geometry::TriangleMesh mesh, const std::string& where = "[container]")
        : wall_(std::make_shared<const geometry::TriangleWall>(std::move(mesh), where)) {}

    [[nodiscard]] core::Json to_json() const override;
    [[nodiscard]] geometry::Bounds bounds() const override { return wall_->bounds(); }
    void column(double x, double y, std::vector<core::Interval>& parts) const override { wall_->column(x, y, parts); }
    [[nodiscard]] std::optional<double> first_hit(const geometry::Vec3& from, const geometry::Vec3& step) const override {
        return wall_->first_hit(from, step);
    }
    [[nodiscard]] double distance(const geometry::Vec3& point) const override { return wall_->distance(point); }
    [[nodiscard]] double least_distance(const geometry::Vec3& a, const geometry::Vec3& b) const override {
        return wall_->least_distance(a, b);
    }
    [[nodiscard]] double mean_area(const core::Interval& heights) const override;
    [[nodiscard]] double side_per_volume() const override;
    [[nodiscard]] std::optional<geometry::VesselWalls> walls() const override { return geometry::VesselWalls{.mesh = wall_}; }

private:
    std::shared_ptr<const geometry::TriangleWall> wall_;
};

/// Of to_json(). Throws UserError with `where`.
[[nodiscard]] geometry::TriangleMesh mesh_from_json(const core::Json& json, const std::string& where);

}  // namespace porepack::vessels
