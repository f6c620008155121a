// Log, progress and cancellation: the interface between the library and its host program, which may replace each function.
#pragma once

#include <functional>
#include <string_view>

namespace porepack::core {

enum class LogLevel { info, warning };

struct Context {
    /// Receives one line of the log, without the line end. Default: stderr.
    std::function<void(LogLevel, std::string_view line)> log;
    /// Progress of a long step: `fraction` of its time in [0, 1] (it does not fall, and stays where it is while it is not known) and
    /// `seconds` since it began; a fraction of 1 ends it. Called a few times per second. Default: a line redrawn on a terminal, a plain
    /// line every ten seconds elsewhere.
    std::function<void(std::string_view label, double fraction, double seconds, std::string_view detail)> progress;
    /// Returns true when the work must stop; called in every long loop, from any thread. Default: true after SIGINT or SIGTERM, if
    /// install_signal_handlers() was called.
    std::function<bool()> interrupted;
};

/// The context of this process. Replace it before work begins; an empty function means the default.
void set_context(Context context);
[[nodiscard]] const Context& context();

}  // namespace porepack::core
