// What OpenFOAM gives on its meshes, in SI units.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::openfoam {

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

struct FoamResult {
    std::vector<FoamMeshResult> meshes;  ///< coarse to fine
    double permeability_m2 = 0.0;        ///< extrapolated when there are two meshes or three
    std::optional<FoamExtrapolation> extrapolation;
    [[nodiscard]] const FoamMeshResult& fine() const { return meshes.back(); }
};

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

}  // namespace porepack::openfoam
