// A parallel loop that passes errors and Ctrl-C on to its caller: an exception must not leave an OpenMP loop directly.
#pragma once

#include <cstddef>
#include <exception>

#include "core/context.hpp"
#include "core/interrupt.hpp"

namespace porepack::inline core {

/// Calls body(i) for 0 <= i < count, in any order. Rethrows one exception of a body; throws MachineError when interrupted.
template <typename Body>
void parallel_for(std::size_t count, const Body& body) {
    std::exception_ptr fault;
    const Context& run = context();
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t i = 0; i < count; ++i) {
        const ContextScope here(run);
        if (interrupted()) continue;
        try {
            body(i);
        } catch (...) {
#pragma omp critical(porepack_parallel_fault)
            fault = std::current_exception();
        }
    }
    if (fault) std::rethrow_exception(fault);
    check_interrupt();
}

}  // namespace porepack::inline core
