// A flow on a fine grid starts from that on a coarser one.
#pragma once

#include "lbm/flow.hpp"

namespace porepack {

/// A flow without its populations, by cell; density NaN where there is none.
struct CoarseFlow {
    Grid grid;
    double viscosity_lu = 0.0;
    std::vector<std::array<float, 4>> cells = {};  ///< density deviation and velocity, lattice units
};
[[nodiscard]] CoarseFlow coarse_flow(const Flow& flow, const Domain& domain, const Scheme& scheme);

/// Sets `flow` to local equilibrium with the coarse flow's velocity and density, trilinear between cell centres and scaled to this grid
/// and viscosity: u ~ F h^-2 / nu and rho ~ F / h for a force that is the same in lattice units.
void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, const CoarseFlow& coarse);

}  // namespace porepack
