// Pouring grains into a container: what both engines share.
#pragma once

#include <optional>

#include "packing/config.hpp"
#include "packing/packing.hpp"
#include "shapes/config.hpp"

namespace porepack::packing {

struct PourPlan {
    double time_step_s = 0.0;
    double contact_time_s = 0.0;  ///< pi / sqrt((s_n/2)/m_ij (1 - eta_n^2)), m_ij = m/2 (consistent with Eq. 9)
    double grain_mass_kg = 0.0;   ///< on average
    double fill_height_m = 0.0;
    double drop_height_m = 0.0;
    long most_grains = 0;    ///< grains prepared; pouring may stop before
    long clump_spheres = 0;  ///< a grain, on average; LIGGGHTS only
    double expected_wall_time_s = 0.0;
    double expected_memory_bytes = 0.0;
};

/// What would run. Throws UserError when the grain does not fit into the container, the stiffness is absurd for its mass, or the time step
/// is too long for it.
[[nodiscard]] PourPlan plan_pour(const std::vector<shapes::ShapeShare>& shapes, const Container& container, const PackingConfig& config);

/// At rest the net force on a grain is below this share of its weight, on the mean: not just turning round.
constexpr double rest_force_limit = 0.02;

/// Digest of all that a pour depends on: what a snapshot must agree with before a run resumes from it.
[[nodiscard]] std::string scene_key(const std::vector<shapes::ShapeShare>& shapes, const Container& container, const PackingConfig& config);

struct PourResult {
    Packing packing;
    long grains = 0;
    long batches = 0;
    long thinned_batches = 0;  ///< of which fewer grains than asked for had room
    long steps = 0;
    double kinetic_energy_per_grain_J = 0.0;
    double rest_limit_J = 0.0;
    [[nodiscard]] bool at_rest() const {
        return kinetic_energy_per_grain_J <= rest_limit_J && mean_force_over_weight.value_or(1.0) <= rest_force_limit;
    }
    std::optional<double> coordination_number;        ///< touching grains a grain
    std::optional<double> largest_force_over_weight;  ///< net force on a grain / its weight, at rest
    std::optional<double> mean_force_over_weight;
    std::optional<double> largest_clump_overlap_m;  ///< LIGGGHTS: of the spheres that it saw
    std::optional<double> pose_error_m;             ///< LIGGGHTS: largest distance between predicted and real clump spheres
    double wall_time_s = 0.0;
    std::string command;  ///< repeats the run by hand, in the run's folder; empty where there is no such thing
};

}  // namespace porepack::packing
