// The solid of a packing, evaluated exactly along vertical lines and short segments: the basis of porosity, voxels, slices and flow.
#pragma once

#include <memory>

#include "core/interval.hpp"
#include "geometry/solid.hpp"
#include "packing/packing.hpp"
#include "shapes/bins.hpp"

namespace porepack::packing {

/// The grains with their periodic images, sorted into bins by (x, y).
class Grains : public geometry::Solid {
public:
    explicit Grains(const Packing& packing);
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] shapes::Bounds bounds() const override { return bounds_; }
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;

    struct Image {
        std::vector<shapes::Capsule> capsules;
        shapes::Bounds bounds;
        std::size_t body;
        shapes::Vec3 shift;  ///< 0 for the body itself
        int image;           ///< 0 for the body itself
    };
    [[nodiscard]] const std::vector<Image>& images() const { return images_; }
    [[nodiscard]] const shapes::Shape& shape_of(const Image& image) const { return shapes_[shape_of_body_[image.body]]; }
    /// The parts of the line origin + t direction (unit vector) inside one grain, its filled cavities included; `parts` is overwritten.
    /// Sorted and disjoint only where the grain has such cavities.
    void line_parts(const Image& image, const shapes::Vec3& origin, const shapes::Vec3& direction,
                    std::vector<core::Interval>& parts) const;
    /// Distance to the nearest grain (capped at `cap`), negative inside, also in a filled cavity; looks only at grains near the point.
    /// Inside, a lower bound of the depth.
    [[nodiscard]] double distance(const shapes::Vec3& point, double cap) const;
    /// Appends the capsules within `reach` of the point along every axis, in the periodic image nearest to the point.
    void capsules_near(const shapes::Vec3& point, double reach, std::vector<shapes::Capsule>& found) const;
    /// Indices of the images whose bounds may contain the column at (x, y), or that lie in the bins around it.
    [[nodiscard]] const std::vector<int>& near(double x, double y) const;

private:
    void add_images(const Packing& packing);
    void sort_into_bins();

    const vessels::Container container_;
    const std::vector<shapes::Shape> shapes_;
    std::vector<std::size_t> shape_of_body_;
    std::vector<shapes::Quaternion> orientation_;
    std::vector<shapes::Vec3> position_;
    std::vector<Image> images_;
    shapes::Bounds bounds_;
    double bin_size_ = 1.0;
    int columns_ = 1, rows_ = 1;
    std::vector<std::vector<int>> bins_;
    std::vector<int> none_;
    std::vector<shapes::Capsule> capsules_;  ///< of all images
    shapes::SpatialBins capsule_bins_{{}};
};

}  // namespace porepack::packing
