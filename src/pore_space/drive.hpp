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

/// Moves `at` by `step`; false beyond an end that is not periodic.
[[nodiscard]] bool step_in_grid(const geometry::Grid& grid, const Drive& drive, std::array<int, 3>& at, const std::array<int, 3>& step);

}  // namespace porepack::pore_space
