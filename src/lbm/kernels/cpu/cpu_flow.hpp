// A flow computed by the fast kernel.
#pragma once

#include "lbm/kernels/cpu/kernel.hpp"

namespace porepack::lbm::cpu {

/// At rest. The domain must outlive the flow.
[[nodiscard]] std::unique_ptr<Flow> make_flow(const Domain& domain, const Scheme& scheme, bool single_precision);

}  // namespace porepack::lbm::cpu
