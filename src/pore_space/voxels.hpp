// Solids to voxels and slices, by cell centres, from exact intervals on vertical lines.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/grid.hpp"
#include "packing/grains.hpp"
#include "packing/section.hpp"

namespace porepack::pore_space {

/// The grid of a section: cubic voxels, z0 on a cell face, the cylinder's axis at the centre of the grid. Where no size near the requested
/// one divides all sides of a periodic box, each side is its own whole number of voxels, which then differ from cubes by 3 % at most.
struct VoxelPlan {
    geometry::Grid grid;
    double voxel_size_m = 0.0;  ///< the requested size, adjusted so that the section is a whole number of voxels; cube root of their volume
    double memory_bytes = 0.0;
};

/// What the grid contains besides the section; rounded up to whole voxels.
struct BeyondSection {
    std::array<double, 2> buffers_m = {0.0, 0.0};  ///< of the bed, below and above the section
    double reservoir_m = 0.0;                      ///< empty container, beyond both
};
/// A size that divides all periodic sides is used within 0.65 to 1.55 times the requested one; with `round_sides` only within 0.85 to 1.18
/// times. Throws UserError when the periodic sides are no whole numbers of such voxels, or the voxel is larger than `grain_size_m`.
[[nodiscard]] VoxelPlan plan_voxels(const vessels::Container& container, const packing::Section& section, double voxel_size_m,
                                    const BeyondSection& beyond, double grain_size_m, bool round_sides = false);

/// Phase of every cell of a grid or of a slab of it; solid beyond the planes of `kept` (default: the section) is left out. Notes: the
/// container and the section.
[[nodiscard]] geometry::PhaseImage voxelise(const geometry::Solid& solid, const vessels::Container& container,
                                            const packing::Section& section, const geometry::Grid& grid,
                                            std::optional<packing::Section> kept = std::nullopt);

/// Phases of the cells of any grid or slab by their centres, where solid beyond the section's planes is left out.
void fill_phases(std::vector<std::uint8_t>& phase, const geometry::Grid& grid, const geometry::Solid& solid,
                 const vessels::Container& container, const packing::Section& section);

/// Fraction of the pore volume that lies in gaps of at most `cells` voxels between solids, along x, y or z.
[[nodiscard]] double narrow_fraction(const geometry::PhaseImage& image, int cells);

}  // namespace porepack::pore_space
