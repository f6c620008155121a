// Small cases that several system tests run.
#pragma once

#include <string>

namespace porepack::test {

// A small pour: 8 tetrapods.
inline const std::string small_case = R"(
[shape]
kind = "tetrapod"
sphericity = 0.53
volume_m3 = 7.33e-7
[container]
kind = "cylinder"
diameter_m = 0.05
height_m = 0.15
[packing]
grains = 8
[geometry]
voxel_size_m = 1e-3
surface_deviation_m = 2e-4
section_m = [0.004, 0.016]
[openfoam]
cell_size_m = 0.002
meshes = 1
)";

}  // namespace porepack::test
