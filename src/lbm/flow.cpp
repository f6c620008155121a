#include "lbm/flow.hpp"

#include "lbm/kernels/cpu/cpu_flow.hpp"
#include "lbm/kernels/reference/reference.hpp"

namespace porepack::lbm {

std::unique_ptr<Flow> make_flow(Kernel kernel, const Domain& domain, const Scheme& scheme) {
    if (kernel == Kernel::reference) return reference::make_flow(domain, scheme);
    return cpu::make_flow(domain, scheme, kernel == Kernel::cpu_single);
}

}  // namespace porepack::lbm
