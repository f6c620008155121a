// A range of values, or an interval of confidence.
#pragma once

namespace porepack::inline core {

struct Interval {
    double low = 0.0;
    double high = 0.0;
    [[nodiscard]] bool operator==(const Interval&) const = default;
};

}  // namespace porepack::inline core
