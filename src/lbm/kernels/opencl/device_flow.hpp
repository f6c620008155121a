// Flows computed by a device (devices/device.hpp): the layout and the equations of the fast kernel of the processor, in lattice.cl.
#pragma once

#include <memory>

#include "devices/device.hpp"
#include "lbm/flow.hpp"

namespace porepack::lbm::opencl {

/// See lbm/flow.hpp.
[[nodiscard]] std::shared_ptr<const FlowPlan> plan_flow(const std::shared_ptr<devices::Device>& device, const Domain& domain,
                                                        bool single_precision);

}  // namespace porepack::lbm::opencl
