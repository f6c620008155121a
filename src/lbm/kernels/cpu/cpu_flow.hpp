// Flows computed by the fast kernel.
#pragma once

#include <memory>

#include "lbm/kernels/cpu/kernel.hpp"

namespace porepack::lbm::cpu {

/// UserError for an instruction set that this processor does not have (chosen_instruction_set).
[[nodiscard]] std::shared_ptr<const FlowPlan> plan_flow(const Domain& domain, bool single_precision);

}  // namespace porepack::lbm::cpu
