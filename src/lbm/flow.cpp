#include "lbm/flow.hpp"

#include "lbm/kernels/cpu/cpu_flow.hpp"
#include "lbm/kernels/opencl/device_flow.hpp"
#include "lbm/kernels/reference/reference.hpp"

namespace porepack::lbm {

std::shared_ptr<const FlowPlan> plan_flow(Kernel kernel, const Domain& domain) {
    if (kernel == Kernel::reference) return reference::plan_flow(domain);
    return cpu::plan_flow(domain, kernel == Kernel::cpu_single);
}

std::shared_ptr<const FlowPlan> plan_flow(const std::shared_ptr<devices::Device>& device, bool single_precision, const Domain& domain) {
    return opencl::plan_flow(device, domain, single_precision);
}

std::unique_ptr<Flow> make_flow(Kernel kernel, const Domain& domain, const Scheme& scheme) {
    return plan_flow(kernel, domain)->start(scheme);
}

}  // namespace porepack::lbm
