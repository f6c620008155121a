// Functions shared by the stages of the falling-head test. Only for the sources of this folder.
#pragma once

#include <string>
#include <vector>

#include "stages/case.hpp"

namespace porepack::stages {

struct InertialPermeability {
    double value_m;
    std::string from;
};
/// k_in of the case's packing, from the stage with the most reliable value.
[[nodiscard]] InertialPermeability inertial_permeability(const Case& c, double porosity);
[[nodiscard]] std::vector<std::string> falling_head_needs(const Case& c);

}  // namespace porepack::stages
