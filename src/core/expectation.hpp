// What a computation will need, before it runs.
#pragma once

#include <string>

namespace porepack::inline core {

/// The time is that on the machine of slowness() = 1; zeros are not shown.
struct Expectation {
    std::string text = {};
    double memory_bytes = 0.0;
    double wall_time_s = 0.0;
    double disk_bytes = 0.0;
};
/// "...; memory about 1.2 GiB, time about 40 s, disk about 30 MiB", with the time multiplied by `slowness`.
[[nodiscard]] std::string text_of(const Expectation& expected, double slowness = 1.0);

}  // namespace porepack::inline core
