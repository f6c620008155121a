// Ctrl-C and SIGTERM set a flag; long loops ask for it, so that no write is interrupted half-way.
#pragma once

namespace porepack::core {

/// For programs; a library that is embedded asks its host (core/context.hpp). Installs the handlers for SIGINT and SIGTERM, and ignores SIGXFSZ and SIGPIPE (the write then reports the error).
void install_signal_handlers();

[[nodiscard]] bool interrupted();

/// Throws MachineError (exit 5) once a signal has come. Cheap enough for every time step.
void check_interrupt();

}  // namespace porepack::core
