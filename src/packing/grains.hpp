// The solid of a packing, evaluated exactly along vertical lines and short segments: the basis of porosity, voxels, slices and flow.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "geometry/solid.hpp"
#include "packing/packing.hpp"
#include "shapes/bins.hpp"
#include "shapes/distance.hpp"

namespace porepack::packing {

/// The grains with their periodic images, sorted into bins by (x, y).
class Grains : public geometry::Solid {
public:
    explicit Grains(Packing packing);
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] shapes::Bounds bounds() const override { return bounds_; }
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;
    /// Looks only at grains near the point; inside one, a filled cavity included, a lower bound of the depth.
    [[nodiscard]] std::optional<double> distance(const shapes::Vec3& point, double cap) const override;
    /// Its capsules and bodies, thinner by `depth`; null where nothing would be left of a shape.
    [[nodiscard]] std::shared_ptr<const geometry::Solid> thinned(double depth) const override;

    [[nodiscard]] const Packing& packing() const { return packing_; }
    struct Image {
        std::vector<shapes::Capsule> capsules;  ///< none of a grain with faces
        shapes::Bounds bounds;
        std::size_t body;
        shapes::Vec3 shift;  ///< 0 for the body itself
        int image;           ///< 0 for the body itself
    };
    [[nodiscard]] const std::vector<Image>& images() const { return images_; }
    [[nodiscard]] const shapes::Shape& shape_of(const Image& image) const { return packing_.shapes[packing_.bodies[image.body].shape]; }
    [[nodiscard]] shapes::PlacedShape placed(const Image& image) const {
        const Body& body = packing_.bodies[image.body];
        return {shape_of(image), body.position_m + image.shift, body.orientation};
    }
    /// The parts of the line origin + t direction (unit vector) inside one grain, its filled cavities included; `parts` is overwritten.
    /// Sorted and disjoint only where the grain has such cavities.
    void line_parts(const Image& image, const shapes::Vec3& origin, const shapes::Vec3& direction,
                    std::vector<core::Interval>& parts) const;
    /// Appends the capsules within `reach` of the point along every axis, in the periodic image nearest to the point.
    void capsules_near(const shapes::Vec3& point, double reach, std::vector<shapes::Capsule>& found) const;
    /// Appends the grains with faces whose bounds come within `reach`, likewise.
    void bodies_near(const shapes::Vec3& point, double reach, std::vector<shapes::PlacedShape>& found) const;
    /// Some grain has faces.
    [[nodiscard]] bool has_bodies() const { return !with_body_.empty(); }
    /// Indices of the images whose bounds may contain the column at (x, y), or that lie in the bins around it.
    [[nodiscard]] const std::vector<int>& near(double x, double y) const;

private:
    void add_images();
    void sort_into_bins();
    void body_parts(const Image& image, const shapes::Vec3& origin, const shapes::Vec3& direction, double grown,
                    std::vector<core::Interval>& parts) const;
    template <typename Visit>
    void for_near(const shapes::SpatialBins& bins, const shapes::Vec3& point, double reach, const Visit& visit) const;

    const Packing packing_;
    std::vector<Image> images_;
    shapes::Bounds bounds_;
    double bin_size_ = 1.0;
    int columns_ = 1, rows_ = 1;
    std::vector<std::vector<int>> bins_;
    std::vector<int> none_;
    std::vector<shapes::Capsule> capsules_;  ///< of all images
    shapes::SpatialBins capsule_bins_{{}};
    std::vector<std::size_t> with_body_;  ///< images of grains with faces
    shapes::SpatialBins body_bins_{{}};
};

}  // namespace porepack::packing
