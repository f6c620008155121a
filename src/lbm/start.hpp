// The moments of a flow, kept without its populations: initial state of a flow on a finer grid, and flow.vti.
#pragma once

#include "lbm/flow.hpp"

namespace porepack::lbm {

/// Density deviation and velocity by node, lattice units.
struct FlowField {
    Domain domain;  ///< without links
    double viscosity_lu = 0.0;
    std::vector<std::array<float, 4>> moments;
};
/// Moves the nodes of `domain` into the field.
[[nodiscard]] FlowField take_field(const Flow& flow, Domain&& domain, const Scheme& scheme);

/// Sets `flow` to local equilibrium with the coarse field's velocity and density, trilinear between cell centres and scaled to this grid
/// and viscosity: u ~ F h^-2 / nu and rho ~ F / h for a force that is the same in lattice units.
void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowField& coarse);

}  // namespace porepack::lbm
