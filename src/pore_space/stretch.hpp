// Factors of the axes that make the cells of a grid cubes.
#pragma once

#include <array>
#include <optional>

#include "geometry/grid.hpp"

namespace porepack::pore_space {

/// Factors of the axes x, y and z.
using Stretch = std::array<double, 3>;
/// That makes the grid's cells cubes of the same volume; none where they are cubes.
[[nodiscard]] std::optional<Stretch> stretch_to_cubes(const geometry::Grid& grid);
void stretch_grid(geometry::Grid& grid, const Stretch& stretch);
/// Largest |factor - 1|.
[[nodiscard]] double strain_of(const std::optional<Stretch>& stretch);

}  // namespace porepack::pore_space
