// The equations of the scheme, written down plainly: what the fast kernels are compared with.
#pragma once

#include "lbm/flow.hpp"

namespace porepack::lbm::reference {

/// At rest. The domain must outlive the flow.
[[nodiscard]] std::unique_ptr<Flow> make_flow(const Domain& domain, const Scheme& scheme);

}  // namespace porepack::lbm::reference::lbm::reference
