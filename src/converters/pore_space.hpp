// The pore space that the solvers use, from exact grains, a closed surface, or an image.
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "converters/voxels.hpp"
#include "converters/walls.hpp"
#include "io/stl.hpp"

namespace porepack::converters {

/// A container, the section of it that is evaluated, and the solid in it. It gives voxels of any size and, where the
/// solid is known exactly, the exact wall positions. Copies share the solid, which is never changed.
struct PoreSpace {
    packing::Container container;
    packing::Section section;
    std::shared_ptr<const packing::Solid> solid = nullptr;         ///< exact; empty for an image
    std::shared_ptr<const packing::Grains> grains = nullptr;       ///< the same solid, if it consists of capsules
    std::shared_ptr<const packing::Packing> packing = nullptr;     ///< packing of these grains
    std::shared_ptr<const io::TriangleSurface> surface = nullptr;  ///< the grains' closed surface, if there is one
    std::shared_ptr<const core::PhaseImage> image = nullptr;       ///< its voxels are the only available resolution

    /// Diameter of the thinnest capsule; of a surface 4 volume / area, the diameter of a long capsule; infinite where unknown.
    double grain_size_m = std::numeric_limits<double>::infinity();
    double maximum_feret_diameter_m = 0.0;  ///< of a grain
    double bed_top_m = 0.0;                 ///< highest point of the solid
    double reservoir_m = 0.0;               ///< empty container beyond both ends of the section, in flow runs

    std::string source = {};  ///< source file, for messages

    [[nodiscard]] bool has_exact_walls() const { return solid != nullptr; }
    /// The grain's diameter where it is known exactly; otherwise infinite.
    [[nodiscard]] double known_grain_diameter_m() const;
    /// `asked_m`, or when that is 0 the default: a tenth of the capsule's diameter, or the image's own voxels. Throws UserError for a
    /// surface, which does not contain the grain diameter.
    [[nodiscard]] double voxel_size_m(double asked_m) const;

    /// The grid at about this voxel size, adjusted so that the section is a whole number of voxels. Throws UserError as plan_voxels.
    [[nodiscard]] VoxelPlan plan_at(double voxel_size_m) const;
    /// Phases on plan_at(voxel_size_m), reservoir included; for an image, the image itself.
    [[nodiscard]] core::PhaseImage voxelise_at(double voxel_size_m) const;
    /// The exact wall positions; empty for an image. The pore space must outlive them.
    [[nodiscard]] std::optional<FlowWalls> walls() const;

    /// The same pore space without reservoirs; an image is cropped to the section.
    [[nodiscard]] PoreSpace section_only() const;
    /// The same pore space with another section.
    [[nodiscard]] PoreSpace with_section(const packing::Section& other) const;
    /// Pore volume over the section's volume, on about `lines` vertical lines. For an image from its voxels, without an uncertainty.
    [[nodiscard]] packing::Porosity porosity(long lines = 60000) const;
    /// Periodic sides of the pore space; along z only where the section is the whole container.
    [[nodiscard]] std::array<bool, 3> periodic_sides() const;
};

/// Exact grains; the section is the whole bed. Throws UserError when the packing is empty.
[[nodiscard]] PoreSpace pore_space_of(packing::Packing packing);
/// An image in its container. Throws UserError when image, container and section do not agree in size; `where` names the image.
[[nodiscard]] PoreSpace pore_space_of(core::PhaseImage image, const packing::Container& container, const packing::Section& section,
                                      const std::string& where);
/// Any other exact solid.
[[nodiscard]] PoreSpace pore_space_of(std::shared_ptr<const packing::Solid> solid, const packing::Container& container,
                                      const packing::Section& section, double grain_size_m);

}  // namespace porepack::converters
