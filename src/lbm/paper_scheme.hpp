// The lattice Boltzmann scheme of the reproduced paper (2.1.4), to compare with.
#pragma once

namespace porepack::lbm {

/// The paper's voxel edge.
inline constexpr double paper_voxel_m = 133.33e-6;

/// k by the paper's scheme (BGK, lattice viscosity 0.03, half-way bounce-back) over k by ours: on body-centred spheres whose diameter is
/// `capsule_diameter_m`, at the paper's voxels and this solid fraction (0.67 at most: the spheres then touch).
[[nodiscard]] double paper_scheme_ratio(double capsule_diameter_m, double solid_fraction);

}  // namespace porepack::lbm
