#include "core/log.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/context.hpp"
#include "core/escape.hpp"

namespace porepack::inline core {
namespace {

// A line of progress is on the terminal, without its end.
std::atomic<bool> line_is_open = false;

// A log that cannot be written must not stop the work.
void to_stderr(const std::string& text) {
    const std::string all = (line_is_open.exchange(false) ? "\r\033[K" : "") + text;
    (void)std::fwrite(all.data(), 1, all.size(), stderr);
}

void tell(LogLevel level, std::string_view text) {
    if (context().log)
        context().log(level, text);
    else
        to_stderr(fmt::format("{}{}\n", level == LogLevel::warning ? "warning: " : "", for_terminal(text)));
}

}  // namespace

void log_line(std::string_view text) {
    tell(LogLevel::info, text);
}

void log_warning(std::string_view text) {
    tell(LogLevel::warning, text);
}

std::string human_time(double seconds) {
    const auto whole = std::lround(seconds);
    if (seconds < 10.0) return fmt::format("{:.1f} s", seconds);
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string human_bytes(double bytes) {
    if (bytes < 1024.0 * 1024.0) return fmt::format("{:.1f} KiB", bytes / 1024.0);
    if (bytes < 1024.0 * 1024.0 * 1024.0) return fmt::format("{:.1f} MiB", bytes / (1024.0 * 1024.0));
    return fmt::format("{:.2f} GiB", bytes / (1024.0 * 1024.0 * 1024.0));
}

Progress::Progress(std::string label) : label_(std::move(label)), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    if (!drawn_) return;
    if (context().progress)
        context().progress(label_, 1.0, watch_.seconds(), {});
    else if (terminal_)
        to_stderr("");
}

void Progress::update_left(std::optional<double> seconds_left, std::string_view detail) {
    const double now = watch_.seconds();
    update(seconds_left ? std::optional(now / std::max(1e-9, now + *seconds_left)) : std::nullopt, detail);
}

void Progress::update(std::optional<double> fraction, std::string_view detail) {
    const double now = watch_.seconds();
    const bool hosted = static_cast<bool>(context().progress);
    if (now - last_ < (terminal_ || hosted ? 0.2 : 10.0)) return;
    last_ = now;
    done_ = std::max(done_, std::min(fraction.value_or(0.0), 1.0));  // never backwards
    drawn_ = true;
    if (hosted) return context().progress(label_, done_, now, detail);
    constexpr double first_shown = 0.1;
    const bool known = fraction && *fraction > first_shown;
    const std::string left = known ? human_time(now * (1.0 - std::min(*fraction, 1.0)) / *fraction) + " left" : "time left unknown";
    const std::string line = fmt::format("{}: {:3.0f} %, {}{}{}", label_, 100.0 * done_, left, detail.empty() ? "" : ", ", detail);
    to_stderr(terminal_ ? line : line + "\n");
    line_is_open = terminal_;
    std::fflush(stderr);
}

}  // namespace porepack::inline core
