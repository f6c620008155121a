// Direct implementation of the equations of the scheme, the reference for the fast kernels.
#pragma once

#include <memory>

#include "lbm/flow.hpp"

namespace porepack::lbm::reference {

/// The plan is a copy of the domain.
[[nodiscard]] std::shared_ptr<const FlowPlan> plan_flow(const Domain& domain);

}  // namespace porepack::lbm::reference
