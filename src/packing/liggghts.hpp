// Packing by LIGGGHTS: writes a run that can be repeated by hand, runs it, reads the poses back and checks them.
#pragma once

#include "packing/config.hpp"
#include "packing/packing.hpp"
#include "shapes/config.hpp"

namespace porepack {

struct PourPlan {
    double time_step_s = 0.0;
    double contact_time_s = 0.0;  ///< pi / sqrt((s_n/2)/m_ij (1 - eta_n^2)), m_ij = m/2 (consistent with Eq. 9)
    double grain_mass_kg = 0.0;   ///< on average
    double fill_height_m = 0.0;
    double drop_height_m = 0.0;
    long most_grains = 0;    ///< grains prepared; pouring may stop before
    long clump_spheres = 0;  ///< a grain, on average
    double expected_wall_time_s = 0.0;
    double expected_memory_bytes = 0.0;
};

/// What would run. Throws UserError when the grain does not fit into the container or the stiffness is absurd for its mass.
[[nodiscard]] PourPlan plan_pour(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config);

struct PourResult {
    Packing packing;
    long grains = 0;
    long batches = 0;
    long steps = 0;
    double kinetic_energy_per_grain_J = 0.0;
    double rest_limit_J = 0.0;
    double pose_error_m = 0.0;  ///< largest distance between predicted and real clump spheres
    double wall_time_s = 0.0;
    double peak_memory_bytes = 0.0;
    std::string command;  ///< repeats the run by hand, in the run's folder
};

/// Runs in `folder` (made, with all inputs and logs in it). `templates` is the folder liggghts_templates/.
/// Throws EngineError when LIGGGHTS is missing, fails or loses a grain, NumericalError when the grains do not come to rest.
[[nodiscard]] PourResult pour_with_liggghts(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                                            const Path& templates, const Path& folder);

}  // namespace porepack
