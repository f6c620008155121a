// Pouring grains into a container: data and functions common to both engines.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "packing/packing.hpp"
#include "pouring/config.hpp"
#include "pouring/protocol.hpp"
#include "shapes/config.hpp"
#include "shapes/sphere_clump.hpp"

namespace porepack::pouring {

using packing::Packing;

/// Of a grain, on average over the shares.
[[nodiscard]] double mean_volume_m3(const std::vector<shapes::ShapeShare>& shapes);
/// Solid fraction in the middle of a poured bed, before it is poured: 0.67 C^0.45, with the convexity C (volume / volume of the convex
/// hull), less 0.36 maximum Feret diameters / width of the container for the loose layer at its wall. Within 10 % for the packings of
/// docs/packing.md (C from 0.2 to 1).
[[nodiscard]] double poured_solid_fraction(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container);
/// Height of the bed of so many grains, by this solid fraction; its loose top adds 0.6 maximum Feret diameters.
[[nodiscard]] double poured_height_m(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container, long grains);

struct ContactTimes {
    double contact_time_s = 0.0;  ///< pi / sqrt((s_n/2)/m_ij (1 - eta_n^2)), m_ij = m/2 (consistent with Eq. 9), of the lightest grain
    double time_step_s = 0.0;
};
/// Contacts that a grain may have at the same time, for the time step: the number of its capsules. Two faces on each other are as stiff as
/// several contacts: a grain with faces counts as 12. Of clumps of grains with faces see plan_pour().
[[nodiscard]] std::size_t contacts_at_once(const shapes::Shape& shape);
/// `diameter_m`: of the thinnest grain; `at_once`: contacts of one grain, which a dashpot of each would push back and forth for ever, so
/// the step is shorter by the square root of their number over 6. Throws UserError when the stiffness is too low for the heaviest grain,
/// or the given step is too long for the lightest.
[[nodiscard]] ContactTimes contact_times(double lightest_kg, double heaviest_kg, double diameter_m, std::size_t at_once,
                                         const PackingConfig& config);

/// The clump of spheres that stands for a shape in LIGGGHTS; its spheres lie inside.
[[nodiscard]] shapes::SphereClump clump_for(const shapes::Shape& shape, const PackingConfig& config);
/// The spheres that LIGGGHTS gets: of a grain with faces larger, so that they have its volume.
[[nodiscard]] std::vector<shapes::Capsule> clump_spheres_for(const shapes::Shape& shape, const PackingConfig& config);

struct PourPlan {
    double time_step_s = 0.0;
    double contact_time_s = 0.0;
    double grain_mass_kg = 0.0;  ///< on average
    double fill_height_m = 0.0;
    double drop_height_m = 0.0;
    long max_grains = 0;                   ///< grains prepared; pouring may stop before
    long clump_spheres = 0;                ///< per grain, on average; LIGGGHTS only
    double expected_steps = 0.0;           ///< of the pour
    double expected_protocol_steps = 0.0;  ///< after it
    double expected_wall_time_s = 0.0;
    double expected_memory_bytes = 0.0;
};

/// Where overlaps of grains with faces exceed this fraction of the thinner grain's thickness the grains begin to pass through each other.
inline constexpr double deepest_overlap = 0.4;

/// The plan of a pour. Throws UserError when the grain does not fit into the container, the stiffness is too low for its mass, the time
/// step is too long for it, or the engine cannot carry a step of the protocol out.
[[nodiscard]] PourPlan plan_pour(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                                 const PackingConfig& config, const ProtocolConfig& protocol = {});

/// At rest the mean net force on a grain is below this fraction of its weight: this excludes grains at a turning point.
constexpr double rest_force_limit = 0.02;

/// Digest of all inputs of a pour: a run resumes from a snapshot only if their digests agree.
[[nodiscard]] std::string scene_key(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                                    const PackingConfig& config, const ProtocolConfig& protocol = {});

struct PourResult {
    Packing packing;
    long grains = 0;
    long batches = 0;
    long thinned_batches = 0;  ///< with fewer grains than requested, for lack of space
    long steps = 0;
    double kinetic_energy_per_grain_J = 0.0;
    double rest_limit_J = 0.0;
    [[nodiscard]] bool at_rest() const {
        return kinetic_energy_per_grain_J <= rest_limit_J && mean_force_over_weight.value_or(1.0) <= rest_force_limit;
    }
    std::optional<double> coordination_number;        ///< grains in contact per grain
    std::optional<double> largest_force_over_weight;  ///< net force on a grain / its weight, at rest
    std::optional<double> mean_force_over_weight;
    std::optional<double> largest_clump_overlap_m;  ///< LIGGGHTS: between the clumps' spheres
    std::optional<double> pose_error_m;             ///< LIGGGHTS: maximum distance between predicted and real clump spheres
    std::vector<ProtocolRow> protocol = {};         ///< the bed after the pour and after each step
    // With a protocol: forces of the grains on the walls, along z.
    std::optional<double> floor_force_N = {}, side_force_N = {}, lid_force_N = {};
    double wall_time_s = 0.0;
    std::string command;  ///< repeats the run by hand, in the run's folder; empty where not available
};

}  // namespace porepack::pouring
