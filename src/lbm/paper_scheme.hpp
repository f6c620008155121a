// The lattice Boltzmann scheme of the reproduced paper (2.1.4), for comparison.
#pragma once

namespace porepack::lbm {

/// Voxel edge of the paper.
inline constexpr double paper_voxel_m = 133.33e-6;

/// k by the paper's scheme (BGK, lattice viscosity 0.03, half-way bounce-back) over k by ours: on body-centred spheres of diameter
/// `capsule_diameter_m`, with the paper's voxels and this solid fraction (at most 0.67: the spheres are then in contact).
[[nodiscard]] double paper_scheme_ratio(double capsule_diameter_m, double solid_fraction);

}  // namespace porepack::lbm
