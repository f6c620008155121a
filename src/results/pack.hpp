// The packing: results/pack/result.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/members.hpp"
#include "results/fit.hpp"

namespace porepack::results {

/// Of the whole bed, from the floor to its top.
struct BedPorosity {
    double bed_height_m = 0.0, porosity_bed = 0.0, porosity_bed_uncertainty = 0.0;  ///< the last: a standard uncertainty
};
template <core::MembersOf<BedPorosity> Self, typename Visit>
void visit_members(Self& bed, const Visit& visit) {
    visit("bed_height_m", bed.bed_height_m);
    visit("porosity_bed", bed.porosity_bed);
    visit("porosity_bed_uncertainty", bed.porosity_bed_uncertainty);
}

/// Cost and errors of the clump of spheres that stands for a grain in LIGGGHTS.
struct Clump {
    std::string shape;
    std::size_t spheres = 0;
    double largest_surface_error_m = 0.0;
    double volume_error = 0.0, area_error = 0.0;  ///< relative
};
template <core::MembersOf<Clump> Self, typename Visit>
void visit_members(Self& clump, const Visit& visit) {
    visit("shape", clump.shape);
    visit("spheres", clump.spheres);
    visit("largest_surface_error_m", clump.largest_surface_error_m);
    visit("volume_error", clump.volume_error);
    visit("area_error", clump.area_error);
}

/// Of a packing that was poured here.
struct Pour {
    long batches = 0, thinned_batches = 0, steps = 0;
    double kinetic_energy_per_grain_J = 0.0, rest_limit_J = 0.0;
    bool at_rest = false;
    core::OptionalKey<double> coordination_number = {}, mean_force_over_weight = {}, largest_force_over_weight = {};
    // Of LIGGGHTS.
    core::OptionalKey<double> pose_error_relative_to_diameter = {}, largest_clump_overlap_relative_to_diameter = {};
    core::OptionalKey<std::vector<Clump>> clumps = {};
    core::OptionalKey<std::string> repeat_by_hand = {};
    double engine_wall_time_s = 0.0;
};
template <core::MembersOf<Pour> Self, typename Visit>
void visit_members(Self& pour, const Visit& visit) {
    visit("batches", pour.batches);
    visit("thinned_batches", pour.thinned_batches);
    visit("steps", pour.steps);
    visit("kinetic_energy_per_grain_J", pour.kinetic_energy_per_grain_J);
    visit("rest_limit_J", pour.rest_limit_J);
    visit("at_rest", pour.at_rest);
    visit("coordination_number", pour.coordination_number);
    visit("mean_force_over_weight", pour.mean_force_over_weight);
    visit("largest_force_over_weight", pour.largest_force_over_weight);
    visit("pose_error_relative_to_diameter", pour.pose_error_relative_to_diameter);
    visit("largest_clump_overlap_relative_to_diameter", pour.largest_clump_overlap_relative_to_diameter);
    visit("clumps", pour.clumps);
    visit("repeat_by_hand", pour.repeat_by_hand);
    visit("engine_wall_time_s", pour.engine_wall_time_s);
}

/// The bed after the pour, and after each step of the protocol.
struct ProtocolStep {
    std::string kind;
    core::OptionalKey<long> taps = {};                         ///< that were done
    core::OptionalKey<double> acceleration_over_gravity = {};  ///< peak, of a vessel that is shaken
    double time_s = 0.0;                                       ///< simulated, since the pour began
    double bed_height_m = 0.0, porosity = 0.0;                 ///< of the section; of a box without walls as a whole
    double coordination_number = 0.0;
    core::OptionalKey<double> coordination_without_rattlers = {};  ///< in a box without walls: grains with fewer than 4 contacts left out
    core::OptionalKey<double> pressure_Pa = {};                    ///< on a plate, or in a box without walls
    bool reached = true;                                           ///< what the step was to reach
};
template <core::MembersOf<ProtocolStep> Self, typename Visit>
void visit_members(Self& step, const Visit& visit) {
    visit("kind", step.kind);
    visit("taps", step.taps);
    visit("acceleration_over_gravity", step.acceleration_over_gravity);
    visit("time_s", step.time_s);
    visit("bed_height_m", step.bed_height_m);
    visit("porosity", step.porosity);
    visit("coordination_number", step.coordination_number);
    visit("coordination_without_rattlers", step.coordination_without_rattlers);
    visit("pressure_Pa", step.pressure_Pa);
    visit("reached", step.reached);
}

struct Protocol {
    std::vector<ProtocolStep> steps;
    // Of the grains on the walls along z, at the end: their weight and a lid's arrive there.
    core::OptionalKey<double> floor_force_N = {}, side_force_N = {}, lid_force_N = {};
};
template <core::MembersOf<Protocol> Self, typename Visit>
void visit_members(Self& protocol, const Visit& visit) {
    visit("steps", protocol.steps);
    visit("floor_force_N", protocol.floor_force_N);
    visit("side_force_N", protocol.side_force_N);
    visit("lid_force_N", protocol.lid_force_N);
}

struct Pack {
    static constexpr const char* stage = "pack";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    std::string engine;  ///< "fit": found in a scan
    core::OptionalKey<long> seed = {};
    core::OptionalKey<Fit> fit = {};
    core::OptionalKey<Pour> pour = {};
    core::OptionalKey<Protocol> protocol = {};
    std::size_t grains = 0;
    core::OptionalKey<core::ByName<long>> grains_of_shape = {};  ///< of a mixture
    double largest_overlap_relative_to_diameter = 0.0, mean_overlap_relative_to_diameter = 0.0;
    double largest_wall_overlap_relative_to_diameter = 0.0;
    long contacts = 0;
    core::OptionalKey<bool> overlap_allowed = {};
    BedPorosity bed = {};
};
template <core::MembersOf<Pack> Self, typename Visit>
void visit_members(Self& pack, const Visit& visit) {
    visit("engine", pack.engine);
    visit("seed", pack.seed);
    visit("fit", pack.fit);
    visit("", pack.pour);
    visit("protocol", pack.protocol);
    visit("grains", pack.grains);
    visit("grains_of_shape", pack.grains_of_shape);
    visit("largest_overlap_relative_to_diameter", pack.largest_overlap_relative_to_diameter);
    visit("mean_overlap_relative_to_diameter", pack.mean_overlap_relative_to_diameter);
    visit("largest_wall_overlap_relative_to_diameter", pack.largest_wall_overlap_relative_to_diameter);
    visit("contacts", pack.contacts);
    visit("overlap_allowed", pack.overlap_allowed);
    visit("", pack.bed);
}

}  // namespace porepack::results
