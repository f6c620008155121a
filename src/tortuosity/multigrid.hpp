// One multigrid V-cycle as a preconditioner; only for the sources of this folder.
#pragma once

#include <vector>

#include "tortuosity/conductance_grid.hpp"

namespace porepack::tortuosity {

/// The given grid and coarser ones, each of half as many cells per side, down to six cells along the longest side.
[[nodiscard]] std::vector<ConductanceGrid> make_grids(ConductanceGrid finest);

/// Solves grids[0] roughly: from its `b` to its `x`. Symmetric, as conjugate gradients need it.
void v_cycle(std::vector<ConductanceGrid>& grids);

}  // namespace porepack::tortuosity
