// Sums over the layers of cells normal to the flow: what k, its iteration error and the balance of the layers are computed from.
#pragma once

#include <vector>

#include "lbm/flow.hpp"
#include "lbm/stokes_run.hpp"

namespace porepack::lbm {

/// The layer of a cell, normal to the flow; fast for cells in ascending order. For one thread.
class LayerFinder {
public:
    explicit LayerFinder(const Domain& domain) : domain_(domain), along_z_(domain.drive.axis == 2) {}
    [[nodiscard]] std::size_t of(std::size_t cell) {
        if (along_z_ && cell - first_cell_ < cells_) return layer_;
        layer_ = domain_.layer_of_cell(cell);
        cells_ = static_cast<std::size_t>(domain_.grid.cells[0]) * static_cast<std::size_t>(domain_.grid.cells[1]);
        first_cell_ = cell / cells_ * cells_;
        return layer_;
    }

private:
    const Domain& domain_;
    bool along_z_;
    std::size_t layer_ = 0, first_cell_ = 0, cells_ = 0;
};

[[nodiscard]] Layers measure_layers(const Flow& flow, const Domain& domain);
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
