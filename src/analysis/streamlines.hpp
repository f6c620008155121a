// Streamlines of a flow image, to look at.
#pragma once

#include <array>
#include <vector>

#include "geometry/grid.hpp"

namespace porepack::analysis {

struct Streamline {
    std::vector<std::array<double, 3>> points_m;
    std::vector<double> speeds_m_per_s;  ///< at the points
};

/// From the upstream end along the axis (0, 1, 2): each of them stands for the same part of the flow rate there. Steps of 0.4 cells by the
/// midpoint rule between the centres of the cells, up to the other end, a side, or where the fluid rests. Every fourth point is kept.
[[nodiscard]] std::vector<Streamline> streamlines(const geometry::FlowImage& flow, int axis, std::size_t number);

}  // namespace porepack::analysis
