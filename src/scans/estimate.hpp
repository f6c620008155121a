// A fitted number.
#pragma once

#include "core/members.hpp"

namespace porepack::scans {

/// A value with its standard uncertainty.
struct Estimate {
    double value = 0.0, uncertainty = 0.0;
};
template <core::MembersOf<Estimate> Self, typename Visit>
void visit_members(Self& estimate, const Visit& visit) {
    visit("value", estimate.value);
    visit("standard_uncertainty", estimate.uncertainty);
}

}  // namespace porepack::scans
