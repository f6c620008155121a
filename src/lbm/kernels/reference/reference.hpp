// Direct implementation of the equations of the scheme, the reference for the fast kernels.
#pragma once

#include "lbm/flow.hpp"

namespace porepack::lbm::reference {

/// At rest. The domain must outlive the flow.
[[nodiscard]] std::unique_ptr<Flow> make_flow(const Domain& domain, const Scheme& scheme);

}  // namespace porepack::lbm::reference
