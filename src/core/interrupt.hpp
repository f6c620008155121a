// Ctrl-C, SIGTERM and SIGUSR1 set a flag that long loops check, so that no write is interrupted half-way.
#pragma once

#include "core/error.hpp"

namespace porepack::inline core {

/// For programs (an embedded library asks its host). Handles SIGINT, SIGTERM, and SIGUSR1, which batch systems can send before a job's time
/// is over and which mpirun passes on; ignores SIGXFSZ and SIGPIPE (the write fails instead).
void install_signal_handlers();

[[nodiscard]] bool interrupted();

struct Interrupted : MachineError {
    Interrupted();
};
/// Throws Interrupted (exit 5) after a signal. Cheap enough for every time step.
void check_interrupt();

}  // namespace porepack::inline core
