// The pore space that the solvers use, from exact grains, a closed surface, or an image.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packing/grains.hpp"
#include "packing/porosity.hpp"
#include "pore_space/config.hpp"
#include "pore_space/link_cuts.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/stretched_solid.hpp"
#include "pore_space/voxels.hpp"
#include "pore_space/walls.hpp"

namespace porepack::pore_space {

class GraySolid;

/// A container, the section of it that is evaluated, and the solid in it. It gives voxels of any size and, where the
/// solid is known exactly, the exact wall positions. Copies share the solid, which is never changed.
struct PoreSpace {
    vessels::Container container;
    packing::Section section;
    Ends ends = Ends::planes;                      ///< see with_ends()
    std::array<double, 2> buffers_m = {0.0, 0.0};  ///< below and above the section: parts of the bed in which the flow is computed too
    std::shared_ptr<const geometry::Solid> solid = nullptr;  ///< none in what is planned before there is one

    /// Diameter of the thinnest capsule; of a surface 4 volume / area, the diameter of a long capsule; infinite where unknown.
    double grain_size_m = std::numeric_limits<double>::infinity();
    double image_voxel_size_m = 0.0;          ///< of a gray image
    double image_porosity_error = 0.0;        ///< of a gray image: standard error by its gray levels and the container's wall
    double maximum_feret_diameter_m = 0.0;    ///< of a grain
    double equivalent_diameter_m = 0.0;       ///< of the sphere with the mean volume of a grain; 0 where unknown
    double bed_bottom_m = 0.0;                ///< lowest point of the solid, not below the floor; of an image its first plane
    double bed_top_m = 0.0;                   ///< highest point of the solid; of an image its last plane
    bool round_sides = false;                 ///< of a periodic box, rather than take a voxel size farther from the one asked for
    double film_thickness_m = 0.0;            ///< of the film that is part of the grains
    double closing_radius_m = 0.0;            ///< of the menisci that are part of the solid
    std::vector<core::Interval> kept_m = {};  ///< heights between which the solid is known; empty: everywhere
    double reservoir_m = 0.0;                 ///< empty container beyond both ends of the computed part, in flow runs

    std::string source = {};  ///< source file, for messages

    [[nodiscard]] bool has_exact_walls() const { return solid && solid->has_exact_walls(); }
    /// The solid, if it is of this kind; else null. The questions that only one kind answers are asked through these.
    [[nodiscard]] const packing::Grains* grains() const;
    [[nodiscard]] const packing::Packing* packing() const;
    [[nodiscard]] const GraySolid* gray() const;
    [[nodiscard]] const geometry::TriangleSurface* surface() const { return solid ? solid->surface() : nullptr; }
    /// The voxels of a segmented image, which are its only resolution; else null.
    [[nodiscard]] const geometry::Grid* own_grid() const { return solid ? solid->own_grid() : nullptr; }

    /// The grain's diameter where it is known exactly; otherwise infinite.
    [[nodiscard]] double known_grain_diameter_m() const;
    /// `asked_m`, or when that is 0 the default: a tenth of the capsule's diameter, or the image's own voxels. Throws UserError for a
    /// surface, which does not contain the grain diameter.
    [[nodiscard]] double voxel_size_m(double asked_m) const;

    /// The grid at about this voxel size, adjusted as by plan_voxels: in a periodic box the voxels may differ from cubes. Throws UserError
    /// as plan_voxels.
    [[nodiscard]] VoxelPlan plan_at(double voxel_size_m) const;
    /// Phases on the grid of plan_at(), or on a slab of it, for which no more memory is needed than it has cells.
    [[nodiscard]] geometry::PhaseImage phases_on(const geometry::Grid& grid) const;
    /// Phases on plan_at(voxel_size_m), buffers and reservoirs included; for an image, its own voxels.
    [[nodiscard]] geometry::PhaseImage voxelise_at(double voxel_size_m) const;
    /// The same pore space stretched; its solid is known as such alone (not as grains, surface or gray
    /// image).
    [[nodiscard]] PoreSpace stretched(const Stretch& stretch) const;
    /// The solid between these planes is a wall of the flow; all of it unless reservoirs lie beyond.
    [[nodiscard]] packing::Section kept_solid() const;
    /// The exact wall positions; empty for an image. The pore space must outlive them.
    [[nodiscard]] std::optional<FlowWalls> walls() const;
    /// The links between pore cells of voxelise_at() that the solid closes.
    [[nodiscard]] LinkCuts link_cuts(const geometry::PhaseImage& phases, const Drive& drive) const;

    /// The section and its buffers: the part in which the flow is computed.
    [[nodiscard]] packing::Section computed() const { return {section.z0_m - buffers_m[0], section.z1_m + buffers_m[1]}; }
    /// The flow goes through the whole bed, from its lowest to its highest point.
    [[nodiscard]] bool computes_whole_bed() const;
    /// The same pore space without buffers and reservoirs; an image is cropped to the section.
    [[nodiscard]] PoreSpace section_only() const;
    /// The same pore space for whoever asks only between these heights: an image then keeps no other layers.
    [[nodiscard]] PoreSpace between(const std::vector<core::Interval>& heights_m) const;
    [[nodiscard]] bool is_known(const packing::Section& part) const;
    /// The same pore space with another section, without buffers.
    [[nodiscard]] PoreSpace with_section(const packing::Section& other) const;
    /// The same pore space with these ends. In situ, each buffer is `buffer_m` long (0: default_buffer_m()), or shorter where the bed or
    /// the image ends. A periodic direction of the flow has no ends. An image
    /// that ends at the section has nothing beyond it: `planes`.
    [[nodiscard]] PoreSpace with_ends(Ends wanted, double buffer_m = 0.0) const;
    /// 1.5 equivalent diameters, but at most half the width of the container (docs/sections.md shows that this is enough).
    [[nodiscard]] double default_buffer_m() const;
    /// True if no path leads through the computed part along `drive`, whatever the voxel size: on voxels of this size, grains whose
    /// diameter is smaller by the diagonal of a voxel block it. False if that is not certain (always for images and surfaces).
    [[nodiscard]] bool certainly_blocked(double voxel_size_m, const Drive& drive) const;
    /// Pore volume over the section's volume, on about `lines` vertical lines. For an image from its voxels, without an uncertainty.
    [[nodiscard]] packing::Porosity porosity(long lines = 60000) const;
    /// Periodic sides of the pore space; along z only where the section is the whole container.
    [[nodiscard]] std::array<bool, 3> periodic_sides() const;
};

/// Voxels for the lattice, which are cubes: where those of a periodic box are not, the box and all that is in it are stretched.
struct CubicVoxels {
    geometry::PhaseImage image;
    PoreSpace space;                      ///< that the image shows
    std::optional<Stretch> stretch = {};  ///< of the pore space that was given; none where its voxels are cubes
};
/// About this voxel size; an image has its own. `part` gives the slab of the whole grid that is wanted. Throws UserError as plan_voxels.
[[nodiscard]] CubicVoxels cubic_voxels(const PoreSpace& space, double voxel_size_m,
                                       const std::function<geometry::Grid(const geometry::Grid&)>& part = {});

/// Exact grains; the section is the whole bed. Throws UserError when the packing is empty.
[[nodiscard]] PoreSpace pore_space_of(packing::Packing packing);
/// An image in its container. Throws UserError when image, container and section do not agree in size; `where` names the image.
[[nodiscard]] PoreSpace pore_space_of(geometry::PhaseImage image, const vessels::Container& container, const packing::Section& section,
                                      const std::string& where);
/// Throws UserError where an image on this grid, the container and the section do not agree in size; `where` names the image.
/// With `shows_wall` it may be wider than a cylinder.
void require_fit(const geometry::Grid& grid, const vessels::Container& container, const packing::Section& section, const std::string& where,
                 bool shows_wall = false);
/// Any other exact solid.
[[nodiscard]] PoreSpace pore_space_of(std::shared_ptr<const geometry::Solid> solid, const vessels::Container& container,
                                      const packing::Section& section, double grain_size_m);

}  // namespace porepack::pore_space
