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

    const Container container_;
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

/// The part of the bed that is evaluated, between two horizontal planes.
struct Section {
    double z0 = 0.0;
    double z1 = 0.0;
    [[nodiscard]] double length() const { return z1 - z0; }
    [[nodiscard]] core::Interval interval() const { return {z0, z1}; }
};

/// The part of a packing between two planes, with cut ends and its floor at z = 0; grains that reach into it are kept whole.
[[nodiscard]] Packing cut_out(const Packing& packing, const Section& part);

struct SectionChoice {
    std::vector<double> section_m;  ///< z0, z1; empty: chosen from the bed
    double trim_m = 0.0;            ///< 0: the smaller of 30 mm and one grain's maximum Feret diameter
    bool bed_known = true;          ///< else `bed` is an estimate, and a section need not lie in it
};
/// The default is `bed` (lowest to highest point of the grains) without the trim at both ends; a container that is periodic along z is
/// used as a whole. Throws UserError with the bed's height when nothing is left.
[[nodiscard]] Section choose_section(const Container& container, const SectionChoice& choice, const Section& bed,
                                     double maximum_feret_diameter_m);

/// The bed, inside the container; the whole container if it is periodic along z.
[[nodiscard]] Section whole_bed(const Container& container, const Section& bed);
/// Periodic sides of the section; along z only when it is the whole box.
[[nodiscard]] std::array<bool, 3> periodic_sides(const Container& container, const Section& section);

struct Porosity {
    double value = 0.0;
    double uncertainty = 0.0;  ///< half the difference between two shifted lattices of lines, or that of single precision
    double line_spacing_m = 0.0;
    long lines = 0;  ///< 0: the volume is exact
};
/// Pore volume / inner container volume of the section: exact for a closed surface inside its container, else from exact intervals on
/// about `lines` vertical lines.
[[nodiscard]] Porosity porosity(const geometry::Solid& solid, const Container& container, const Section& section, long lines = 60000);

}  // namespace porepack::packing
