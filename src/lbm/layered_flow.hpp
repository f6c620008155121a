// The flow of a run in SI units, for flow.vti.
#pragma once

#include "geometry/grid.hpp"
#include "lbm/permeability.hpp"
#include "lbm/start.hpp"

namespace porepack::lbm {

/// Velocity and pressure of water at this superficial velocity: Stokes flow is linear. The pressure is zero at the outlet; in a periodic
/// cell it is the pressure without the driving gradient. `force` in lattice units, on each node of the field. Image and field are of the
/// whole grid or of a slab of it; then the first part asks for layers, while the others answer.
[[nodiscard]] geometry::LayeredFlow layered_flow(geometry::PhaseImage&& image, FlowField&& field, const geometry::Grid& whole,
                                                 const LbmGridResult& result, double force, double superficial_velocity_m_per_s);

/// Of all parts but the first: gives the layers of its slab for which the first part asks, until that ends it.
void answer_first_part(const geometry::LayeredFlow& flow);
/// Of the first part: no more layers are needed.
void end_answers(const geometry::LayeredFlow& flow, const core::Communicator& parts);

}  // namespace porepack::lbm
