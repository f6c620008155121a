#include "core/log.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace porepack {

// A log that cannot be written must not end the work.
void log_raw(const std::string& text) {
    (void)std::fwrite(text.data(), 1, text.size(), stderr);
}

void log_line(std::string_view text) {
    log_raw(fmt::format("{}\n", text));
}

void log_warning(std::string_view text) {
    log_raw(fmt::format("warning: {}\n", text));
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
    if (terminal_ && drawn_) log_raw("\r\033[K");
}

void Progress::update(double fraction, std::string_view detail) {
    const double now = watch_.seconds();
    if (now - last_ < (terminal_ ? 0.2 : 10.0)) return;
    last_ = now;
    done_ = std::max(done_, std::min(fraction, 1.0));  // never backwards
    const double done = done_;
    const std::string left = done > 0.01 ? human_time(now * (1.0 - done) / done) + " left" : "time left unknown";
    const std::string line = fmt::format("{}: {:3.0f} %, {}{}{}", label_, 100.0 * done, left, detail.empty() ? "" : ", ", detail);
    if (terminal_)
        log_raw(fmt::format("\r\033[K{}", line));
    else
        log_line(line);
    std::fflush(stderr);
    drawn_ = true;
}

}  // namespace porepack
