// What the geometry and flow stages work on: a packing, or a user's closed surface in a container.
#pragma once

#include <memory>
#include <optional>

#include "converters/config.hpp"
#include "converters/surface.hpp"
#include "converters/voxels.hpp"

namespace porepack {

struct Scene {
    Container container;
    std::optional<Packing> packing;
    std::optional<TriangleSurface> surface;
    std::unique_ptr<Grains> grains;               ///< when there is a packing
    std::unique_ptr<SurfaceSolid> surface_solid;  ///< when there is only a surface
    double grain_size_m = 0.0;                    ///< smallest capsule diameter; of a surface 4 volume / area
    double grain_span_m = 0.0;
    double bed_top_m = 0.0;
    Section section;

    [[nodiscard]] const Solid& solid() const { return grains ? static_cast<const Solid&>(*grains) : *surface_solid; }
    /// Default voxel: the smallest capsule diameter / 10; a surface has none.
    [[nodiscard]] double voxel_size(const GeometryConfig& geometry) const;
    /// Default: 0.5 % of the smallest capsule diameter.
    [[nodiscard]] double surface_deviation(const GeometryConfig& geometry) const {
        return geometry.surface_deviation_m > 0.0 ? geometry.surface_deviation_m : 0.005 * grain_size_m;
    }
};

/// `input` is packing.json[.gz] or an .stl, which needs `container`; the section is the whole bed. Throws UserError on
/// anything else.
[[nodiscard]] Scene load_bed(const Path& input, const std::optional<Container>& container, double unit_m);
/// The same with the section that `geometry` asks for.
[[nodiscard]] Scene load_scene(const Path& input, const std::optional<Container>& container, const GeometryConfig& geometry, double unit_m);

/// Means over a packing's grains.
struct GrainMeans {
    double equivalent_diameter_m;  ///< of the sphere of the mean volume
    double sauter_diameter_m;      ///< 6 volume / area
};
[[nodiscard]] GrainMeans grain_means(const Packing& packing);

/// The section as an image's field data tells it. Throws UserError.
[[nodiscard]] Section section_of_note(const std::string& note, const Path& file);

struct ImageScene {
    PhaseImage image;
    Container container;
    Section section;
};
/// A pore.vti; what its field data do not tell must be given. Throws UserError when the image and the container differ in size.
[[nodiscard]] ImageScene load_image(const Path& pore_vti, const std::optional<Container>& container, const std::vector<double>& section_m);

}  // namespace porepack
