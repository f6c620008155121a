// Finite volumes whose faces are cut by exact walls; only for the sources of this folder.
#pragma once

#include "pore_space/link_cuts.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/walls.hpp"
#include "tortuosity/conductance_grid.hpp"

namespace porepack::tortuosity {

/// Finite volumes on cells whose faces are as open as the solid and the container leave them.
struct CutCells {
    ConductanceGrid grid;     ///< conductances over that of a face without solid; at planes twice as much
    double thin_solid = 0.0;  ///< of the cells at walls, the share where the solid is thinner than a cell: errors of first order
};
/// Cells whose centre is solid conduct too, where a part of their faces is open. `image` has the phases of the cell centres; of its pores
/// only those that hang together with `percolation` conduct.
[[nodiscard]] CutCells cut_cells(const geometry::PhaseImage& image, const pore_space::Percolation& percolation,
                                 const pore_space::LinkCuts& cuts, const pore_space::FlowWalls& walls, const pore_space::Drive& drive);

}  // namespace porepack::tortuosity
