// Permeability by OpenFOAM: fills in a case of openfoam_cases/, runs its Allrun, and checks the run by its output and by
// its numbers, never by the exit code (which is 0 after divergence).
#pragma once

#include <optional>
#include <span>

#include "converters/surface.hpp"
#include "core/files.hpp"
#include "core/interval.hpp"
#include "core/members.hpp"
#include "openfoam/config.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::openfoam {

struct FoamScene {
    io::TriangleSurface surface;  ///< the grains; for a periodic box with the images that extend into it
    packing::Container container;
    packing::Section section;                         ///< meshed: from the inlet to the outlet
    std::optional<packing::Section> evaluated = {};   ///< part that k refers to, inside the flow; without it, all of `section`
    double pore_volume_m3 = 0.0;                      ///< exact, of what is meshed
    double grain_size_m = 0.0;                        ///< smallest capsule diameter, or 4 volume / area of a surface
    std::optional<pore_space::PoreSpace> pores = {};  ///< gives the gaps that are too narrow for mesh cells; without it no gap counts
    shapes::Vec3 pore_point = shapes::Vec3::Zero();   ///< a point in the pore space that flow reaches, far from grains and walls
};
/// The section of a pore space with its buffers, its surface within `surface` of the exact one (a user's surface is used unchanged).
/// `coarsest_cell_m` is the background cell of the coarsest mesh.
[[nodiscard]] FoamScene foam_scene(const pore_space::PoreSpace& space, const converters::SurfaceOptions& surface, double coarsest_cell_m);
/// The same between two layers of free water; the grains are cut off where the buffers end.
[[nodiscard]] FoamScene foam_scene_in_water(const pore_space::PoreSpace& space, const converters::SurfaceOptions& surface, double cell_m,
                                            double water_m);
/// Fraction of the pore volume in gaps that are narrower than two voxels of this size.
[[nodiscard]] double narrow_pores(const pore_space::PoreSpace& space, double voxel_size_m);

struct FoamMeshResult {
    double cell_size_m = 0.0;
    long cells = 0;
    long skew_faces = 0;  ///< accepted although their skewness exceeds the limit of checkMesh, 4
    double max_non_orthogonality = 0.0;
    double mesh_volume_ratio = 0.0;  ///< meshed / exact pore volume
    double narrow_pores = 0.0;       ///< fraction of the exact pore volume in gaps that are narrower than two cells
    long iterations = 0;
    bool converged = false;       ///< by the residuals or by the flow rate, see foam.cpp
    double flow_imbalance = 0.0;  ///< |q_in + q_out| / |q_in|
    double flow_drift = 0.0;      ///< relative change of the flow rate over the last 10 iterations
    double permeability_m2 = 0.0;
    long processes = 1;  ///< of the solver
    double wall_time_s = 0.0;
    double peak_memory_bytes = 0.0;
};
template <core::MembersOf<FoamMeshResult> Self, typename Visit>
void visit_members(Self& mesh, const Visit& visit) {
    visit("cell_size_m", mesh.cell_size_m);
    visit("cells", mesh.cells);
    visit("max_non_orthogonality_deg", mesh.max_non_orthogonality);
    visit("skew_faces", mesh.skew_faces);
    visit("mesh_volume_ratio", mesh.mesh_volume_ratio);
    visit("narrow_pores", mesh.narrow_pores);
    visit("iterations", mesh.iterations);
    visit("converged", mesh.converged);
    visit("flow_imbalance", mesh.flow_imbalance);
    visit("flow_drift", mesh.flow_drift);
    visit("permeability_m2", mesh.permeability_m2);
    visit("processes", mesh.processes);
    visit("wall_time_s", mesh.wall_time_s);
    visit("peak_memory_bytes", mesh.peak_memory_bytes);
}

/// Extrapolation from meshes of different sizes. The size of a mesh is cells^(-1/3): snapped meshes refine at surfaces, so the ratio of
/// background cells overestimates the refinement.
struct FoamExtrapolation {
    double value;
    core::Interval interval;
    std::optional<double> observed_order;  ///< of three meshes, if k changes monotonically
    std::optional<double>
        grid_convergence_index;  ///< of three meshes: relative half width about the finest one (Roache; Celik et al. 2008)
    bool lost_pores = false;     ///< not extrapolated: see without_lost_pores()
};
/// `cells` and `values` of two or three meshes, coarse to fine. Two: order 1.5, the interval covers orders 1 and 2. Three: the observed
/// order if it is between 1.5 and 2.5, and the interval covers half an order more and less; else order 2, covering 1 to 3; at least 0.5 %.
/// If k does not change monotonically: the finest value with three times the maximum change.
[[nodiscard]] FoamExtrapolation extrapolate_meshes(std::span<const double> cells, std::span<const double> values);

/// A mesh gives too large a k. If k grows with refinement instead, and a coarser mesh lacks more than 3 % of the pores (`volume_ratios`:
/// meshed / exact), then it grows because throats open: no order describes that. k is then that of the finest mesh, and the interval holds
/// all meshes and what extrapolation would have given.
[[nodiscard]] FoamExtrapolation without_lost_pores(FoamExtrapolation found, std::span<const double> values,
                                                   std::span<const double> volume_ratios);

struct FoamResult {
    std::vector<FoamMeshResult> meshes;  ///< coarse to fine
    double permeability_m2 = 0.0;        ///< extrapolated when there are two meshes or three
    std::optional<FoamExtrapolation> extrapolation;
    [[nodiscard]] const FoamMeshResult& fine() const { return meshes.back(); }
};

/// Number of background cells.
[[nodiscard]] std::array<int, 3> background_cells(const packing::Container& container, const packing::Section& section, double cell_size_m);
/// The pore cell of the image that flow reaches and that is farthest from all other cells, slightly off its centre.
[[nodiscard]] shapes::Vec3 find_pore_point(const geometry::PhaseImage& image, const packing::Container& container);

/// Runs in `folder`/mesh_fine, mesh_coarse and mesh_coarsest, config.meshes of them; runs resume from the files of an interrupted one
/// there. `cases` is the folder openfoam_cases/. Throws EngineError when OpenFOAM is missing, fails, or has bad output; NumericalError when
/// it does not converge.
[[nodiscard]] FoamResult foam_permeability(const FoamScene& scene, const FoamConfig& config, double cell_size_m, const core::Path& cases,
                                           const core::Path& folder);

/// A steady flow with inertia under a kinematic pressure drop.
struct FoamInertialFlow {
    double pressure_drop_m2_per_s2 = 0.0;
    double superficial_velocity_m_per_s = 0.0;
    double momentum_share = 0.0;  ///< fraction of the drop that becomes momentum of the water between the planes
    /// Apparent: of the evaluated part by the drop of its flux-weighted total pressure p + u^2/2; where the scene has no evaluated part,
    /// of all that is meshed by the drag, which is the drop minus the momentum gained.
    double permeability_m2 = 0.0;
    long iterations = 0;
};
struct FoamInertialSeries {
    FoamMeshResult mesh;
    std::vector<FoamInertialFlow> flows;
    std::optional<std::string> stopped_by;  ///< why a drop has no result; nothing when all were found
};
inline constexpr double water_viscosity_m2_per_s = 1e-6;

/// Runs openfoam_cases/inertial_packing in `folder`/inertial at increasing pressure drops (kinematic, water), until no flow is steady.
/// An interrupted run resumes. Throws as foam_permeability.
[[nodiscard]] FoamInertialSeries foam_inertial_flows(const FoamScene& scene, const FoamConfig& config, double cell_size_m,
                                                     std::span<const double> drops, const core::Path& cases, const core::Path& folder);

/// Throws EngineError when a program is missing.
void require_foam();

}  // namespace porepack::openfoam
