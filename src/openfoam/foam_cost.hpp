// What a mesh of OpenFOAM will need.
#pragma once

#include "pore_space/pore_space.hpp"

namespace porepack::openfoam {

/// Cells of snappyHexMesh. Those that touch a surface, and two layers beside them, are refined: this measured rule holds within 15 % on
/// twelve meshes (surface_level 1). Without grains, their surface is that of capsules of the smallest diameter.
[[nodiscard]] double expected_foam_cells(const pore_space::PoreSpace& space, double cell_size_m, long surface_level, double porosity);
/// Of one mesh, from the same meshes.
[[nodiscard]] inline double foam_memory_bytes(double cells) {
    return 1.2e8 + 2800.0 * cells;
}
[[nodiscard]] inline double foam_disk_bytes(double cells) {
    return 270.0 * cells;
}

}  // namespace porepack::openfoam
