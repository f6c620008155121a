// The grids on which a permeability is computed, and what each part of the computation needs of the pore space on them.
#pragma once

#include <vector>

#include "lbm/config.hpp"
#include "lbm/slabs.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::lbm {

inline constexpr double first_nodes_per_grain = 6.0;  ///< of a run with a tolerance
inline constexpr double same_size = 1.02;             ///< of the voxels of two grids, at most

/// The configuration within the limits of the pore space: an image has cubic voxels of one size. UserError for what it does not allow.
[[nodiscard]] LbmConfig fitted_to(const pore_space::PoreSpace& space, LbmConfig config);

/// Voxel sizes without a tolerance, coarse to fine. The features of an image may be as thin as its voxels: grids that are coarser than they
/// are left out.
[[nodiscard]] std::vector<double> grid_sizes(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config);

/// Nodes per grain diameter on the first grid of a run with a tolerance.
[[nodiscard]] double first_nodes(const pore_space::PoreSpace& space, const LbmConfig& config);

/// Voxel size of the first grid.
[[nodiscard]] double coarsest_size(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config);

/// A periodic box may have too few voxel sizes that divide all its sides: then they are rounded. UserError where that does not help.
[[nodiscard]] pore_space::PoreSpace with_different_grids(const pore_space::PoreSpace& space, const std::vector<double>& sizes);

/// Where the grids of lbm_permeability() are cut for these parts, all of which call it.
[[nodiscard]] SlabCuts slab_cuts(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config,
                                 const core::Communicator& parts);

/// What lbm_permeability() asks of the pore space for this part, with these cuts: of an image, the layers of its slab on every grid, and
/// those in the middle on which the relaxation time is searched. `porosity` is that of the whole.
[[nodiscard]] pore_space::PoreSpace space_of_part(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config,
                                                  const SlabCuts& cuts, double porosity, const core::Communicator& parts);

}  // namespace porepack::lbm
