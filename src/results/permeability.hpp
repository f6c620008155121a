// A permeability in the units that people use, with its interval.
#pragma once

#include <optional>

#include "core/interval.hpp"
#include "core/members.hpp"
#include "permeability/permeability.hpp"

namespace porepack::results {

struct Permeability {
    double m2 = 0.0;
    std::optional<core::Interval> interval_m2{};  ///< numerical, of 95 %; none: no uncertainty is known
};
template <core::MembersOf<Permeability> Self, typename Visit>
void visit_members(Self& k, const Visit& visit) {
    visit("permeability_m2", k.m2);
    visit("permeability_interval_m2", k.interval_m2);
    double darcy = k.m2 / permeability::darcy_m2, conductivity = permeability::conductivity_m_per_s(k.m2);
    visit("permeability_darcy", darcy);
    visit("conductivity_m_per_s", conductivity);
}

}  // namespace porepack::results
