// Grains of a given packing at rest: `porepack pack --from`.
#pragma once

#include <optional>
#include <string>

#include "core/members.hpp"

namespace porepack::results {

struct Relax {
    std::size_t grains = 0;
    long grains_held = 0;   ///< through the floor of a bed with cut ends: their support is not in the packing
    long grains_whole = 0;  ///< not cut by an end of the scan
    double overlap_before_m = 0.0;
    double overlap_m = 0.0;
    double moved_median_m = 0.0;  ///< of the centres of mass
    double moved_largest_m = 0.0;
    long grain_moved_most = 0;
    double turned_median_degrees = 0.0;
    double mean_force_over_weight = 0.0;
    double kinetic_energy_per_grain_J = 0.0;
    long steps = 0;
    double engine_wall_time_s = 0.0;
    std::optional<double> coordination_number_before{};  ///< others that a whole grain touches, on average
    std::optional<double> coordination_number{};
    std::string meaning =
        "coordination numbers: others that a whole grain touches, on average, as given and at rest; whole: not cut by an end of the scan; "
        "held: reaches through the floor of a bed with cut ends, so that its support is not in the packing; moved: of the centre of mass";
};
template <core::MembersOf<Relax> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("grains", found.grains);
    visit("grains_held", found.grains_held);
    visit("grains_whole", found.grains_whole);
    visit("overlap_before_m", found.overlap_before_m);
    visit("overlap_m", found.overlap_m);
    visit("moved_median_m", found.moved_median_m);
    visit("moved_largest_m", found.moved_largest_m);
    visit("grain_moved_most", found.grain_moved_most);
    visit("turned_median_degrees", found.turned_median_degrees);
    visit("mean_force_over_weight", found.mean_force_over_weight);
    visit("kinetic_energy_per_grain_J", found.kinetic_energy_per_grain_J);
    visit("steps", found.steps);
    visit("engine_wall_time_s", found.engine_wall_time_s);
    visit("coordination_number_before", found.coordination_number_before);
    visit("coordination_number", found.coordination_number);
    visit("meaning", found.meaning);
}

}  // namespace porepack::results
