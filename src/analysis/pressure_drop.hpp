// The pressure drop of a bed at a flow rate, from the results of its case.
#pragma once

#include <optional>
#include <string>

#include "permeability/fluid.hpp"
#include "results/pressure_drop.hpp"
#include "results/results.hpp"

namespace porepack::analysis {

struct PressureDropQuestion {
    std::string fluid;  ///< in words
    permeability::Fluid properties = {};
    std::optional<double> flow_rate_m3_per_s = {}, superficial_velocity_m_per_s = {};  ///< one of them
    std::optional<double> length_m = {};                                               ///< none: the bed's height
    double area_m2 = 0.0;                                                              ///< mean area of the section
    std::optional<double> equivalent_diameter_m = {};  ///< of the sphere with a grain's mean volume; none without grains
    std::optional<double> sauter_diameter_m = {};      ///< 6 volume / area of the grains
    std::string name;                                  ///< of the case, for messages
};

/// Needs the results of the stages lbm and voxelise or pack; of forchheimer where inertia is more than 1 %. Throws UserError where they are
/// missing, or do not reach the flow rate, with the command that computes them.
[[nodiscard]] results::PressureDrop pressure_drop(const results::CaseResults& found, const PressureDropQuestion& question);

}  // namespace porepack::analysis
