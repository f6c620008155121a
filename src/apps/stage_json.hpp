// What the stages' results share: vectors as lists, k in the units that people use. Only for the sources of this room.
#pragma once

#include <optional>

#include "core/files.hpp"
#include "packing/grains.hpp"
#include "permeability/permeability.hpp"

namespace porepack {

inline Json list(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

inline Json list(const Section& section) {
    return {section.z0, section.z1};
}

inline Json list(const std::optional<Interval>& interval) {
    if (!interval) return nullptr;
    return {interval->low, interval->high};
}

inline void add_permeability(Json& json, double permeability_m2, const std::optional<Interval>& interval) {
    json["permeability_m2"] = permeability_m2;
    json["permeability_interval_m2"] = list(interval);
    json["permeability_darcy"] = permeability_m2 / darcy_m2;
    json["conductivity_m_per_s"] = conductivity_m_per_s(permeability_m2);
}

}  // namespace porepack
