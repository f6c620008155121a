// A segmented image as a solid: what lies in its voxels of grain.
#pragma once

#include "geometry/solid.hpp"

namespace porepack::pore_space {

/// Walls lie half-way between the centres of its voxels.
class ImageSolid : public geometry::Solid {
public:
    explicit ImageSolid(geometry::PhaseImage image) : image_(std::move(image)) {}
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    /// Empty: between two pores of an image, only the edge that two solid voxels share closes a link (find_cuts).
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] geometry::Bounds bounds() const override;
    /// Of segments from the centre of a voxel to that of a neighbour.
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;
    [[nodiscard]] bool has_exact_walls() const override { return false; }
    [[nodiscard]] const geometry::PhaseImage* own_voxels() const override { return &image_; }

private:
    class Probe;
    const geometry::PhaseImage image_;
};

}  // namespace porepack::pore_space
