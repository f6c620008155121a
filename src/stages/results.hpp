// Functions shared by the results of the stages. Only for the sources of stages and study.
#pragma once

#include <cmath>

#include "core/members.hpp"
#include "packing/grains.hpp"
#include "permeability/permeability.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::stages {

[[nodiscard]] inline core::Json section_json(const packing::Section& section) {
    return {section.z0, section.z1};
}

/// k in the usual units, with its interval (null: no uncertainty is known).
inline void add_permeability(core::Json& json, double permeability_m2, const std::optional<core::Interval>& interval) {
    json["permeability_m2"] = permeability_m2;
    json["permeability_interval_m2"] = core::json_of(interval);
    json["permeability_darcy"] = permeability_m2 / permeability::darcy_m2;
    json["conductivity_m_per_s"] = permeability::conductivity_m_per_s(permeability_m2);
}

/// A number, or null if it is infinite: JSON has no infinity. In an interval, null means that there is no bound.
[[nodiscard]] inline core::Json number_or_null(double value) {
    return std::isfinite(value) ? core::Json(value) : core::Json(nullptr);
}

/// A number of a result, or an interval, by its path ("/lbm/permeability_m2"); none where it, or one of its bounds, is missing or null.
[[nodiscard]] inline std::optional<double> number_at(const core::Json& json, const std::string& path) {
    const core::Json::json_pointer at(path);
    return json.contains(at) && json.at(at).is_number() ? std::optional(json.at(at).get<double>()) : std::nullopt;
}
[[nodiscard]] inline std::optional<core::Interval> interval_at(const core::Json& json, const std::string& path) {
    const auto low = number_at(json, path + "/0"), high = number_at(json, path + "/1");
    return low && high ? std::optional(core::Interval{*low, *high}) : std::nullopt;
}

/// Of the machine of core::slowness() = 1, in double precision with interpolated walls (docs/lattice-boltzmann.md).
inline constexpr double lattice_updates_per_second = 5e7;

/// Keeps the key of version 0.1 next to the new one, until version 0.3.
inline void keep_old_name(core::Json& json, const char* old_key, const char* key) {
    json[old_key] = json.at(key);
}

}  // namespace porepack::stages
