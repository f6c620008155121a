// The flow of a run in SI units, for flow.vti.
#pragma once

#include "geometry/grid.hpp"
#include "lbm/permeability.hpp"
#include "lbm/start.hpp"

namespace porepack::lbm {

/// Velocity and pressure of water at this superficial velocity: Stokes flow is linear. The pressure is zero at the outlet; in a periodic
/// cell it is the pressure without the driving gradient. `force` in lattice units, on each node of the field. Image and field are of the
/// whole grid or of a slab of it.
[[nodiscard]] geometry::LayeredFlow layered_flow(geometry::PhaseImage&& image, FlowField&& field, const geometry::Grid& whole,
                                                 const LbmGridResult& result, double force, double superficial_velocity_m_per_s);

}  // namespace porepack::lbm
