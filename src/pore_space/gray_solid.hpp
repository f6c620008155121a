// The solid of a gray image: where its values, interpolated between the voxels' centres, are above a level.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "geometry/gray_image.hpp"
#include "geometry/known_layers.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::pore_space {

/// Trilinear interpolation; beyond the outermost centres the values stay, in periodic directions they continue at the other side.
class GraySolid : public geometry::Solid {
public:
    /// Solid above image.level.
    GraySolid(std::shared_ptr<const geometry::GrayImage> image, const vessels::Container& container);
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] shapes::Bounds bounds() const override;
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;
    [[nodiscard]] std::shared_ptr<const geometry::Solid> between(const std::vector<core::Interval>& heights_m,
                                                                 bool periodic) const override;

    /// Its grid is the whole one; between() keeps the values of some of its layers only.
    [[nodiscard]] const std::shared_ptr<const geometry::GrayImage>& image() const { return image_; }
    [[nodiscard]] double level() const { return level_; }
    /// Interpolated solid fraction.
    [[nodiscard]] double value(const shapes::Vec3& point) const;
    /// The same solid with another level.
    [[nodiscard]] GraySolid with_level(double level) const;

private:
    class Probe;
    struct Place {
        int low, high;  ///< cells; along z places of kept layers
        double part;    ///< of the way from low to high
    };
    [[nodiscard]] Place place(int axis, double coordinate) const;

    std::shared_ptr<const geometry::GrayImage> image_;
    geometry::KnownLayers layers_;  ///< that image_ holds
    std::array<bool, 3> periodic_;
    double level_;
};

/// A gray image in its container; its voxels are the voxel size by default. Throws UserError where image, container and section do not
/// agree in size; `where` names the image.
[[nodiscard]] pore_space::PoreSpace pore_space_of(std::shared_ptr<const GraySolid> solid, const vessels::Container& container,
                                                  const packing::Section& section, const std::string& where);

}  // namespace porepack::pore_space
