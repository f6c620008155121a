// Pore cells that the flow can reach.
#pragma once

#include "core/choice.hpp"
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
    std::int64_t isolated_cells = 0;  ///< pore cells that the flow cannot reach
};
/// Keeps the pieces of pore space (connected through cell faces, except closed links) that join the inlet to the outlet, or that wind round
/// a periodic box in the direction of flow. Throws DoesNotPercolate when there is none.
[[nodiscard]] Percolation find_percolating_cells(const geometry::PhaseImage& image, const Drive& drive, const LinkCuts& cuts);
/// Without closed links.
[[nodiscard]] Percolation find_percolating_cells(const geometry::PhaseImage& image, const Drive& drive);

}  // namespace porepack::pore_space
