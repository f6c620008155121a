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

struct Pack {
    static constexpr const char* stage = "pack";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    std::string engine;  ///< "fit": found in a scan
    core::OptionalKey<long> seed = {};
    core::OptionalKey<Fit> fit = {};
    core::OptionalKey<Pour> pour = {};
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
