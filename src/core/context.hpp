// Log, progress and cancellation of a run: the interface between the library and its host program, which may replace each function.
#pragma once

#include <functional>
#include <string_view>

namespace porepack::inline core {

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

/// What this thread works for: its own scope's context, or one whose functions are all empty, which means the defaults.
[[nodiscard]] const Context& context();

/// The work of this thread belongs to a run with this context, until the scope ends; several threads may each have a run of their own. A
/// thread that is started for a run begins with such a scope of the context() of the thread that starts it; parallel_for() does so.
class ContextScope {
public:
    /// `context` must outlive the scope.
    explicit ContextScope(const Context& context);
    explicit ContextScope(Context&&) = delete;
    ~ContextScope();
    ContextScope(const ContextScope&) = delete;
    ContextScope& operator=(const ContextScope&) = delete;

private:
    const Context* before_;
};

}  // namespace porepack::inline core
