// How a flow is driven, and what lies beyond the faces of its grid.
#pragma once

#include <array>

#include "geometry/grid.hpp"

namespace porepack::pore_space {

/// How the flow is driven, and the conditions at the grid's faces.
struct Drive {
    int axis = 2;  ///< direction of the flow
    std::array<bool, 3> periodic = {false, false, false};
    [[nodiscard]] bool by_pressure() const { return !periodic[static_cast<std::size_t>(axis)]; }
};

/// Moves `at` by `step`; false beyond an end that is not periodic, and beyond the layers of a slab.
[[nodiscard]] bool step_in_grid(const geometry::Grid& grid, const Drive& drive, std::array<int, 3>& at, const std::array<int, 3>& step);

/// The step leads through an open end: beyond the first or last cell along the drive's axis, where the flow is driven by pressure.
[[nodiscard]] bool through_open_end(const geometry::Grid& grid, const Drive& drive, const std::array<int, 3>& at,
                                    const std::array<int, 3>& step);

}  // namespace porepack::pore_space
