// Permeability by OpenFOAM: fills in a case of openfoam_cases/, runs its Allrun, and checks the run by its output and by
// its numbers, never by the exit code (which is 0 after divergence).
#pragma once

#include <array>
#include <optional>
#include <span>

#include "converters/surface.hpp"
#include "core/files.hpp"
#include "openfoam/config.hpp"
#include "openfoam/foam_result.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::openfoam {

struct FoamScene {
    geometry::TriangleSurface surface;  ///< the grains; for a periodic box with the images that extend into it
    vessels::Container container;
    packing::Section section;                         ///< meshed: from the inlet to the outlet
    std::optional<packing::Section> evaluated = {};   ///< part that k refers to, inside the flow; without it, all of `section`
    double pore_volume_m3 = 0.0;                      ///< exact, of what is meshed
    double grain_size_m = 0.0;                        ///< smallest thickness of the grains, or 4 volume / area of a surface
    std::optional<pore_space::PoreSpace> pores = {};  ///< gives the gaps that are too narrow for mesh cells; without it no gap counts
    shapes::Vec3 pore_point = shapes::Vec3::Zero();   ///< a point in the pore space that flow reaches, far from grains and walls
};
/// The section of a pore space with its buffers, its surface within `surface` of the exact one (a user's surface is used unchanged).
/// `coarsest_cell_m` is the background cell of the coarsest mesh.
/// With `made`, that surface of the grains is used.
[[nodiscard]] FoamScene foam_scene(const pore_space::PoreSpace& space, const converters::SurfaceOptions& surface, double coarsest_cell_m,
                                   const geometry::TriangleSurface* made = nullptr);
/// The same between two layers of free water; the grains are cut off where the buffers end.
[[nodiscard]] FoamScene foam_scene_in_water(const pore_space::PoreSpace& space, const converters::SurfaceOptions& surface, double cell_m,
                                            double water_m);
/// Fraction of the pore volume in gaps that are narrower than two voxels of this size.
[[nodiscard]] double narrow_pores(const pore_space::PoreSpace& space, double voxel_size_m);

/// `cells` and `values` of two or three meshes, coarse to fine. Two: order 1.5, the interval covers orders 1 and 2. Three: the observed
/// order if it is between 1.5 and 2.5, and the interval covers half an order more and less; else order 2, covering 1 to 3; at least 0.5 %.
/// If k does not change monotonically: the finest value with three times the maximum change.
[[nodiscard]] FoamExtrapolation extrapolate_meshes(std::span<const double> cells, std::span<const double> values);

/// A mesh gives too large a k. If k grows with refinement instead, and a coarser mesh lacks more than 3 % of the pores (`volume_ratios`:
/// meshed / exact), then it grows because throats open: no order describes that. k is then that of the finest mesh, and the interval holds
/// all meshes and what extrapolation would have given.
[[nodiscard]] FoamExtrapolation without_lost_pores(FoamExtrapolation found, std::span<const double> values,
                                                   std::span<const double> volume_ratios);

/// Number of background cells.
[[nodiscard]] std::array<int, 3> background_cells(const vessels::Container& container, const packing::Section& section, double cell_size_m);
/// The pore cell of the image that flow reaches and that is farthest from all other cells, slightly off its centre.
[[nodiscard]] shapes::Vec3 find_pore_point(const geometry::PhaseImage& image, const vessels::Container& container);

/// Runs in `folder`/mesh_fine, mesh_coarse and mesh_coarsest, config.meshes of them; runs resume from the files of an interrupted one
/// there. `cases` is the folder openfoam_cases/. Throws EngineError when OpenFOAM is missing, fails, or has bad output; NumericalError when
/// it does not converge.
[[nodiscard]] FoamResult foam_permeability(const FoamScene& scene, const FoamConfig& config, double cell_size_m, const core::Path& cases,
                                           const core::Path& folder);

inline constexpr double water_viscosity_m2_per_s = 1e-6;

/// Runs openfoam_cases/inertial_packing in `folder`/inertial at increasing pressure drops (kinematic, water), until no flow is steady.
/// An interrupted run resumes. Throws as foam_permeability.
[[nodiscard]] FoamInertialSeries foam_inertial_flows(const FoamScene& scene, const FoamConfig& config, double cell_size_m,
                                                     std::span<const double> drops, const core::Path& cases, const core::Path& folder);

/// Throws EngineError when a program is missing.
void require_foam();

}  // namespace porepack::openfoam
