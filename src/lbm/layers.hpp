// Pressure on planes through a flow, from the sums over its layers (Flow::layers).
#pragma once

#include <vector>

#include "lbm/stokes_run.hpp"
#include "pore_space/drive.hpp"

namespace porepack::lbm {

/// Mean over all nodes, from the number of nodes and the mean of each layer.
[[nodiscard]] double mean_density(const std::vector<double>& nodes, const std::vector<double>& density);

/// The pressure on a plane through the flow.
enum class PlanePressure {
    flux_weighted,  ///< int p u dA / int u dA: flow rate times its difference is the power that is dissipated in between
    mean            ///< over the fluid
};
/// Density deviation on the plane below the layer `plane` (0 .. number of layers). Zero on end planes of constant pressure.
[[nodiscard]] double density_on_plane(const pore_space::Drive& drive, const Layers& layers, std::size_t plane,
                                      PlanePressure pressure = PlanePressure::flux_weighted);
/// Flux-weighted kinetic energy per mass, u^2 / 2, on a plane inside the flow; with it, the pressure becomes the total pressure.
[[nodiscard]] double kinetic_energy_on_plane(const Layers& layers, std::size_t plane);
/// Pressure gradient that drives the flow between the layers first and last: the body force `force`, and the drop of the remaining
/// pressure between the planes before and behind them.
[[nodiscard]] double gradient_between(double force, const pore_space::Drive& drive, const Layers& layers, std::size_t first,
                                      std::size_t last, PlanePressure pressure = PlanePressure::flux_weighted);

}  // namespace porepack::lbm
