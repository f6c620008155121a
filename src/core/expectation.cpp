#include "core/expectation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "core/log.hpp"

namespace porepack::inline core {

std::string text_of(const Expectation& expected, double slowness) {
    std::vector<std::string> parts;
    if (expected.memory_bytes > 0.0) parts.push_back("memory about " + human_bytes(expected.memory_bytes));
    if (expected.wall_time_s > 0.0) parts.push_back("time about " + human_time(expected.wall_time_s * slowness));
    if (expected.disk_bytes > 0.0) parts.push_back("disk about " + human_bytes(expected.disk_bytes));
    return fmt::format("{}{}{}", expected.text, expected.text.empty() || parts.empty() ? "" : "; ", fmt::join(parts, ", "));
}

}  // namespace porepack::inline core
