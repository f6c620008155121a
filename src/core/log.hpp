// The log and the progress of long steps. They go to stderr unless the host program replaces them (core/context.hpp).
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace porepack::inline core {

void log_line(std::string_view text);
void log_warning(std::string_view text);

template <typename... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
    log_line(fmt::format(format, std::forward<Args>(args)...));
}

/// Seconds in readable form: "42 s", "3 min 05 s", "2 h 10 min".
[[nodiscard]] std::string human_time(double seconds);
/// Bytes in readable form: "1.3 GiB".
[[nodiscard]] std::string human_bytes(double bytes);

class Stopwatch {
public:
    [[nodiscard]] double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Progress with time left: one line redrawn on a terminal, a plain line every ten seconds elsewhere.
class Progress {
public:
    explicit Progress(std::string label);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// `fraction` of the time that has passed, in [0, 1], or nothing while it is not known; `detail` is shown behind it. The time left is
    /// shown after the first tenth.
    void update(std::optional<double> fraction, std::string_view detail = {});
    /// The same, where the seconds that are left are estimated.
    void update_left(std::optional<double> seconds_left, std::string_view detail = {});

private:
    std::string label_;
    bool terminal_;
    bool drawn_ = false;
    Stopwatch watch_;
    double last_ = 0.0;
    double done_ = 0.0;
};

}  // namespace porepack::inline core
