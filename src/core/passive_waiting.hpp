// Called first in main(): idle threads of OpenMP sleep soon instead of turning in a loop.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <string>

namespace porepack::inline core {

/// Waiting threads that turn in a loop take the processor from other programs, and on a shared machine make two threads slower than
/// one. OpenMP reads its settings while the program is loaded, before main() and before the C library lets a program change its
/// environment: so the settings are made, and the program is started again in place of itself. Threads wait about 10 microseconds,
/// which the end of a short loop needs, then sleep. What the user has set stays. Where the program cannot be started again it goes on.
inline void wait_passively(char** arguments) {
    if (std::getenv("OMP_WAIT_POLICY") != nullptr || std::getenv("GOMP_SPINCOUNT") != nullptr) return;
    setenv("OMP_WAIT_POLICY", "passive", 1);
    setenv("GOMP_SPINCOUNT", "3000", 1);
    std::string program(4096, '\0');  // the file itself: lists of processes show its name
    const auto length = readlink("/proc/self/exe", program.data(), program.size() - 1);
    if (length > 0) (void)execv(program.c_str(), arguments);
}

}  // namespace porepack::inline core
