// Ctrl-C and SIGTERM set a flag that long loops check, so that no write is interrupted half-way.
#pragma once

namespace porepack::core {

/// For programs (an embedded library asks its host). Handles SIGINT and SIGTERM; ignores SIGXFSZ and SIGPIPE (the write fails instead).
void install_signal_handlers();

[[nodiscard]] bool interrupted();

/// Throws MachineError (exit 5) after a signal. Cheap enough for every time step.
void check_interrupt();

}  // namespace porepack::core
