// A film on all grains of a packing, as of a binder.
#pragma once

#include "packing/packing.hpp"
#include "packing/section.hpp"

namespace porepack::packing {

/// Each grain, with all points nearer to it than `thickness_m`: again a union of capsules, or a body of its kind, so this is exact. The
/// films overlap where grains touch, and walls, which cut them; the packing may overlap. Throws UserError where the film closes the hole of
/// a ring.
[[nodiscard]] Packing coated(Packing packing, double thickness_m);

/// The thickness at which the films fill this part of the space between two heights; their overlaps count once. To 1e-4 of itself. Throws
/// UserError where the pores are smaller than that.
[[nodiscard]] double film_thickness(const Packing& packing, const Section& part, double volume_fraction);

}  // namespace porepack::packing
