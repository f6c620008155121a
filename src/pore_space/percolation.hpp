// Pore cells that the flow can reach.
#pragma once

#include <array>
#include <cstdint>

#include "core/choice.hpp"
#include "core/communicator.hpp"
#include "core/error.hpp"
#include "packing/packing.hpp"
#include "pore_space/cell_set.hpp"
#include "pore_space/drive.hpp"

namespace porepack::pore_space {

/// Throws UserError for a flow direction that the container does not allow.
[[nodiscard]] Drive choose_drive(const vessels::Container& container, core::Axis direction);

class LinkCuts;  // link_cuts.hpp

struct DoesNotPercolate : core::NumericalError {
    using core::NumericalError::NumericalError;
};

struct Percolation {
    CellSet cells;                    ///< reachable by the flow
    std::int64_t all_cells = 0;       ///< of all slabs
    std::int64_t isolated_cells = 0;  ///< pore cells of all slabs that the flow cannot reach
    std::array<CellSet, 2> beyond;    ///< of a slab: the cells in the layers next to it, below and above; without words where there is none
};
/// Keeps the pieces of pore space (connected through cell faces, except closed links) that join the inlet to the outlet, or that wind round
/// a periodic box in the direction of flow. Throws DoesNotPercolate when there is none. Of a slab, the phases with its halo and the cuts
/// without it; each slab finds its own pieces, and those that reach a face are joined with the pieces beyond.
[[nodiscard]] Percolation find_percolating_cells(const geometry::PhaseImage& image, const Drive& drive, const LinkCuts& cuts,
                                                 const core::Communicator& parts = core::no_communicator());
/// Without closed links.
[[nodiscard]] Percolation find_percolating_cells(const geometry::PhaseImage& image, const Drive& drive);

}  // namespace porepack::pore_space
