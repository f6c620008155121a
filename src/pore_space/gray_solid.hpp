// The solid of a gray image: where its values, interpolated between the voxels' centres, are above a level.
#pragma once

#include <optional>

#include "core/interval.hpp"
#include "geometry/gray_image.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::pore_space {

/// Trilinear interpolation; beyond the outermost centres the values stay, in periodic directions they continue at the other side.
class GraySolid : public geometry::Solid {
public:
    /// Solid above image.level.
    GraySolid(std::shared_ptr<const geometry::GrayImage> image, const packing::Container& container);
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] shapes::Bounds bounds() const override;
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;

    [[nodiscard]] const std::shared_ptr<const geometry::GrayImage>& image() const { return image_; }
    [[nodiscard]] double level() const { return level_; }
    /// Interpolated solid fraction.
    [[nodiscard]] double value(const shapes::Vec3& point) const;
    /// The same solid with another level.
    [[nodiscard]] GraySolid with_level(double level) const;

private:
    class Probe;
    struct Place {
        int low, high;
        double part;  ///< of the way from low to high
    };
    [[nodiscard]] Place place(int axis, double coordinate) const;

    std::shared_ptr<const geometry::GrayImage> image_;
    std::array<bool, 3> periodic_;
    double level_;
};

/// What the edges and the noise of a gray image tell. Lengths in voxels.
struct GrayMeasures {
    double blur = 0.0;               ///< standard deviation of the point spread function, from the slope of the values at the walls
    double area_per_volume_m = 0.0;  ///< of the level set, in the container; from crossings along the axes, for surfaces of any direction
    double solid_fraction = 0.0;     ///< of the level set
    double gray_fraction = 0.0;      ///< mean of the gray values
    double slope = 0.0;              ///< change of the level set's solid fraction with the level
};
/// In the container, without `margin_voxels` at a cylinder's wall.
[[nodiscard]] GrayMeasures measure_gray(const GraySolid& solid, const packing::Container& container, double margin_voxels = 3.0);

/// Means of the voxels that lie so deep in pores and solid that blur does not reach them, with their standard errors from eight parts of
/// the image; nothing for a phase that has less than 64 such voxels.
struct Plateaus {
    struct Mean {
        double value = 0.0, error = 0.0;
        int depth_voxels = 0;  ///< smaller than asked where there are too few deep voxels
    };
    std::optional<Mean> pores, solid;
};
[[nodiscard]] Plateaus plateaus(const GraySolid& solid, const packing::Container& container, int depth_voxels, double margin_voxels = 3.0);
/// The same image in which `pores` becomes 0 and `solid` becomes 1.
void rescale(geometry::GrayImage& image, double pores, double solid);

/// Volume of the level set over that of the container, without the margin, as measure_gray().
[[nodiscard]] double solid_fraction(const GraySolid& solid, const packing::Container& container, double margin_voxels = 3.0);

/// The level whose solid has the volume of the gray values, whatever their blur. Throws UserError where there is none between 0.1 and 0.9.
[[nodiscard]] double volume_keeping_level(const GraySolid& solid, const packing::Container& container, double margin_voxels = 3.0);

/// A gray image in its container; its voxels are the voxel size by default. Throws UserError where image, container and section do not
/// agree in size; `where` names the image.
[[nodiscard]] pore_space::PoreSpace pore_space_of(std::shared_ptr<const GraySolid> solid, const packing::Container& container,
                                                  const packing::Section& section, const std::string& where);

/// Means of factor x factor x factor voxels; what is left over at the far sides is dropped. In the same place.
[[nodiscard]] geometry::GrayImage averaged(const geometry::GrayImage& image, int factor);

/// Smooths the values by a Gaussian of this standard deviation. At the sides as GraySolid.
void smooth(geometry::GrayImage& image, double sigma_voxels, const std::array<bool, 3>& periodic);

}  // namespace porepack::pore_space
