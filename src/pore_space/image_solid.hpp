// A segmented image as a solid: what lies in its voxels of grain.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "geometry/known_layers.hpp"
#include "geometry/solid.hpp"

namespace porepack::pore_space {

/// Walls lie half-way between the centres of its voxels.
class ImageSolid : public geometry::Solid {
public:
    explicit ImageSolid(geometry::PhaseImage image) : image_(std::move(image)), layers_(image_.grid) {}
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    /// Empty: between two pores of an image, only the edge that two solid voxels share closes a link (find_cuts).
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] geometry::Bounds bounds() const override;
    /// Of segments from the centre of a voxel to that of a neighbour.
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;
    [[nodiscard]] bool has_exact_walls() const override { return false; }
    [[nodiscard]] const geometry::Grid* own_grid() const override { return &image_.grid; }
    [[nodiscard]] geometry::PhaseImage own_phases(const geometry::Grid& layers) const override;
    [[nodiscard]] std::shared_ptr<const geometry::Solid> between(const std::vector<core::Interval>& heights_m,
                                                                 bool periodic) const override;

private:
    class Probe;
    /// `image` has the whole grid, and the phases of these layers.
    ImageSolid(geometry::PhaseImage image, geometry::KnownLayers layers) : image_(std::move(image)), layers_(std::move(layers)) {}
    [[nodiscard]] bool is_grain(int i, int j, int layer) const {
        return image_.phase[image_.grid.index(i, j, layers_.place(layer))] == geometry::Phase::grain;
    }

    const geometry::PhaseImage image_;
    const geometry::KnownLayers layers_;  ///< that image_ holds
};

}  // namespace porepack::pore_space
