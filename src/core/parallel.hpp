// A parallel loop from which errors and Ctrl-C come out: neither may leave an OpenMP loop on its own.
#pragma once

#include <cstddef>
#include <exception>

#include "core/interrupt.hpp"

namespace porepack::core {

/// body(i) for i below `count`, in any order. Throws what a body threw (one of them); throws MachineError once interrupted.
template <typename Body>
void parallel_for(std::size_t count, const Body& body) {
    std::exception_ptr fault;
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t i = 0; i < count; ++i) {
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

}  // namespace porepack::core
