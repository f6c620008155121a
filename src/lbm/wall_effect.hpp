// Effect of the container wall on the flow through a packing in a tube.
#pragma once

#include <vector>

#include "pore_space/pore_space.hpp"

namespace porepack::lbm {

/// A ring of the tube, between two radii.
struct Ring {
    double r0_m = 0.0;
    double r1_m = 0.0;
    double porosity = 0.0;           ///< of the cells of the flow
    double relative_velocity = 0.0;  ///< superficial velocity in the ring over that of the tube
};
/// Rings of equal width, from the axis to the wall; each cell counts for the ring that holds its centre.
[[nodiscard]] std::vector<Ring> radial_profile(const geometry::FlowImage& flow, const packing::Section& section, double diameter_m,
                                               long rings);

/// k of the core, `layer_m` from the wall, over k of the whole tube: mean velocities in the section. NaN if there is no core.
[[nodiscard]] double core_over_tube(const geometry::FlowImage& flow, const packing::Section& section, double diameter_m, double layer_m);
/// The same by one coarse flow (6 nodes per capsule diameter) through the section of `space`, whose container is a cylinder.
[[nodiscard]] double core_over_tube_permeability(const pore_space::PoreSpace& space, double layer_m);

}  // namespace porepack::lbm
