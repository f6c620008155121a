// Given grains, moved as little as possible until they no longer overlap and rest on each other.
#pragma once

#include <vector>

#include "packing/packing.hpp"
#include "pouring/config.hpp"

namespace porepack::pouring::dem {

using packing::Packing;

struct Relaxed {
    Packing packing;                 ///< the bodies in their order
    std::vector<bool> held;          ///< reaches through the floor of a bed with cut ends: what it rests on is not in the packing
    std::vector<double> moved_m;     ///< of each grain: distance of the centre of mass from where it was
    std::vector<double> turned_rad;  ///< and its rotation
    double overlap_before_m = 0.0;   ///< largest, between grains
    double overlap_after_m = 0.0;    ///< about that of a grain's weight on a contact
    double mean_force_over_weight = 0.0;
    double kinetic_energy_per_grain_J = 0.0;
    long steps = 0;
    double wall_time_s = 0.0;
};

/// First without weight and without inertia, until no overlap is larger than that of three grains' weight; then with gravity until the
/// grains are at rest, by the criteria of a pour. Grains that reach through the floor of a bed with cut ends are held then; those that
/// reach through its top are not, because grains rest on what is below. Of `config` the properties of the grains, the time step and the
/// criteria for rest are used. Deterministic. Throws UserError when grains overlap by more than half of the thinnest capsule's
/// diameter, and NumericalError when the overlaps do not vanish or the grains do not come to rest.
[[nodiscard]] Relaxed relax(const Packing& packing, const PackingConfig& config);

}  // namespace porepack::pouring::dem
