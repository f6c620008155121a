// An error that is told again, as text with its kind.
#pragma once

#include <string>

#include "core/error.hpp"

namespace porepack::inline core {

/// Throws the error of this kind whose what() is `text`, which has its advice already.
[[noreturn]] inline void throw_as(ExitCode code, const std::string& text) {
    switch (code) {
        case ExitCode::user:
            throw UserError(text);
        case ExitCode::numerical:
            throw NumericalError(text);
        case ExitCode::engine:
            throw EngineError(text);
        default:
            throw MachineError(text);
    }
}

}  // namespace porepack::inline core
