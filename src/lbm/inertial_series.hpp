// Flows with inertia, as computed (inertia.hpp).
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/members.hpp"
#include "lbm/stokes_run.hpp"
#include "pore_space/stretch.hpp"

namespace porepack::lbm {

/// A flow at Re = U length / nu, U being the superficial velocity: steady, or the mean in time.
struct InertialFlow {
    double reynolds = 0.0;
    /// Apparent permeability. In situ: nu U / (gradient of the flux-weighted total pressure p + u^2/2 between the planes). Else
    /// nu U / (drag of grains and walls / volume of the section).
    double permeability_m2 = 0.0;
    double momentum_share = 0.0;        ///< fraction of the pressure drop that accelerates the water between the end planes
    double kinetic_energy_share = 0.0;  ///< in situ: fraction of the drop of the total pressure that is due to the flux of kinetic energy
    double iteration_error = 0.0;
    bool converged = false;
    double relaxation_time = 0.0;
    double fastest_lu = 0.0;  ///< maximum velocity on a node; compressibility errors grow with its square
    /// Of a mean in time, else nothing. Where the steady scheme is not stable, the collision has less accurate walls; what they do to k is
    /// measured on creeping flow at the same viscosity, and removed from the permeability.
    struct InTime {
        bool steady = false;                 ///< the flow does not change any more
        double half_width = 0.0;             ///< relative, of the 95 % interval of the mean velocity: statistical
        double fluctuation = 0.0;            ///< standard deviation of the mean velocity in time, over its mean
        double kinetic_energy_factor = 0.0;  ///< <u^2> / <u_z>^2 over the fluid
        double lateral_share = 0.0;          ///< velocity across the flow over that along it
        double turnovers = 0.0;              ///< time, in passages of the mean velocity in the pores by one grain diameter
        double correlation_turnovers = 0.0;
        double wall_error = 0.0;  ///< k of creeping flow by the recursive collision over that by the steady one, minus 1; 0: the steady one
        static constexpr double wall_error_tolerance = 2e-3;  ///< iteration error of the creeping flow
        /// Relative. After the correction, at most a quarter of the wall error was left (simple cubic spheres, Re up to 20).
        [[nodiscard]] double wall_half_width() const { return wall_error == 0.0 ? 0.0 : 0.5 * std::abs(wall_error) + wall_error_tolerance; }
    };
    std::optional<InTime> in_time = {};
    long steps = 0;
    double seconds = 0.0;
    std::vector<ConvergencePoint> history = {};  ///< of a steady flow; not written
    /// Of the permeability, relative, independent of the other flows: iteration error, or the standard error of the mean in time.
    [[nodiscard]] double error() const { return in_time ? in_time->half_width / 1.96 : iteration_error; }
};
template <core::MembersOf<InertialFlow::InTime> Self, typename Visit>
void visit_members(Self& mean, const Visit& visit) {
    visit("steady", mean.steady);
    visit("statistical_half_width", mean.half_width);
    visit("velocity_fluctuation", mean.fluctuation);
    visit("kinetic_energy_factor", mean.kinetic_energy_factor);
    visit("lateral_velocity_share", mean.lateral_share);
    visit("turnovers", mean.turnovers);
    visit("correlation_turnovers", mean.correlation_turnovers);
    visit("wall_error", mean.wall_error);
    double half_width = mean.wall_half_width();
    visit("wall_half_width", half_width);
}
template <core::MembersOf<InertialFlow> Self, typename Visit>
void visit_members(Self& flow, const Visit& visit) {
    visit("reynolds", flow.reynolds);
    visit("permeability_m2", flow.permeability_m2);
    visit("momentum_share", flow.momentum_share);
    visit("kinetic_energy_share", flow.kinetic_energy_share);
    visit("iteration_error", flow.iteration_error);
    visit("converged", flow.converged);
    visit("relaxation_time", flow.relaxation_time);
    visit("fastest_lattice_velocity", flow.fastest_lu);
    visit("mean_in_time", flow.in_time);
    visit("steps", flow.steps);
    visit("wall_time_s", flow.seconds);
}

struct InertialSeries {
    double voxel_size_m = 0.0;
    std::optional<pore_space::Stretch> stretch = {};  ///< of a periodic box, to whole numbers of voxels
    std::size_t nodes = 0;
    double creeping_permeability_m2 = 0.0;
    double peak_over_mean = 0.0;            ///< maximum velocity / superficial velocity, creeping flow
    std::vector<InertialFlow> flows;        ///< rising
    std::optional<std::string> stopped_by;  ///< why the next flow has no result; nothing when all were found
};
template <core::MembersOf<InertialSeries> Self, typename Visit>
void visit_members(Self& series, const Visit& visit) {
    visit("voxel_size_m", series.voxel_size_m);
    visit("stretch", series.stretch);
    visit("nodes", series.nodes);
    visit("creeping_permeability_m2", series.creeping_permeability_m2);
    visit("peak_over_mean_velocity", series.peak_over_mean);
    visit("stopped_by", series.stopped_by);
    visit("flows", series.flows);
}

}  // namespace porepack::lbm
