// Pore cells that the flow can reach.
#pragma once

#include "core/choice.hpp"
#include "core/error.hpp"
#include "geometry/grid.hpp"
#include "packing/packing.hpp"
#include "pore_space/cell_set.hpp"

namespace porepack::pore_space {

/// How the flow is driven, and the conditions at the grid's faces.
struct Drive {
    int axis = 2;  ///< direction of the flow
    std::array<bool, 3> periodic = {false, false, false};
    [[nodiscard]] bool by_pressure() const { return !periodic[static_cast<std::size_t>(axis)]; }
};

/// Throws UserError for a flow direction that the container does not allow.
[[nodiscard]] Drive choose_drive(const packing::Container& container, core::Axis direction);

/// Moves `at` by `step`; false beyond an end that is not periodic.
[[nodiscard]] bool step_in_grid(const geometry::Grid& grid, const Drive& drive, std::array<int, 3>& at, const std::array<int, 3>& step);

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
