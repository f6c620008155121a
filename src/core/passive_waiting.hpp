// Included by the main file of a program: idle threads of OpenMP sleep instead of turning in a loop.
#pragma once

#include <cstdlib>

namespace porepack::core {

// OpenMP reads its settings before main() and before any constructor, so this runs earlier still. Waiting threads that turn in a loop
// take the processor from other programs, and on a shared machine make two threads slower than one. What the user has set stays.
inline void wait_passively(int, char**, char**) {
    setenv("OMP_WAIT_POLICY", "passive", 0);
}
__attribute__((section(".preinit_array"), used)) static void (*const before_openmp)(int, char**, char**) = wait_passively;

}  // namespace porepack::core
