// The moments of a flow, kept without its populations: initial state of a flow on a finer grid, and flow.vti.
#pragma once

#include <array>
#include <cstdint>

#include "core/pages.hpp"
#include "lbm/flow.hpp"

namespace porepack::lbm {

/// Density deviation and velocity by node, lattice units.
struct FlowField {
    Domain domain;  ///< without links
    double viscosity_lu = 0.0;
    core::Pages<std::array<float, 4>> moments;
    int layers_beyond = 0;  ///< of other slabs, which the domain has at each side where there are some
};
/// Moves the nodes of `domain` into the field. The flow forgets its populations on the way, so that no more memory is needed.
[[nodiscard]] FlowField take_field(Flow& flow, Domain&& domain, const Scheme& scheme);

/// The field of a slab, with `layers` of those of the slabs below and above; all slabs call it. Of a whole grid the field itself.
[[nodiscard]] FlowField with_layers_beyond(FlowField&& field, int layers);

/// The eight cells around a place in metres, with their trilinear weights; -1 where there is no node. Beyond an open end the nearest cell
/// is used.
struct NodesAround {
    std::array<std::int64_t, 8> node;
    std::array<double, 8> weight;
};
[[nodiscard]] NodesAround nodes_around(const Domain& domain, const std::array<double, 3>& place);

/// Of a slab, the coarse field holds the layers around it (with_layers_beyond).
/// Sets `flow` to local equilibrium with the coarse field's velocity and density, trilinear between cell centres and scaled to this grid
/// and viscosity: u ~ F h^-2 / nu and rho ~ F / h for a force that is the same in lattice units.
void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowField& coarse);
/// The same; moments of the field are given back as the populations come into being, so that the memory of both is not needed at once.
void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, FlowField&& coarse);

}  // namespace porepack::lbm
