// What the library tells its host while it works, and how the host ends the work. A program that embeds the library replaces this.
#pragma once

#include <functional>
#include <string_view>

namespace porepack::core {

enum class LogLevel { info, warning };

struct Context {
    /// One line of the log, without its end. Default: stderr.
    std::function<void(LogLevel, std::string_view line)> log;
    /// Progress of a long step: `fraction` done in [0, 1] and `seconds` since it began; a fraction of 1 ends it. Called a few times per
    /// second. Default: a line redrawn on a terminal, a plain line every ten seconds elsewhere.
    std::function<void(std::string_view label, double fraction, double seconds, std::string_view detail)> progress;
    /// True once the work is to end; asked in every long loop, from any thread. Default: SIGINT or SIGTERM came, where
    /// install_signal_handlers() was called.
    std::function<bool()> interrupted;
};

/// Of this process. Replace it before work begins; an empty function means the default.
void set_context(Context context);
[[nodiscard]] const Context& context();

}  // namespace porepack::core
