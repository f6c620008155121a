// The median, with one convention for even numbers of values.
#pragma once

#include <algorithm>
#include <vector>

namespace porepack::inline core {

/// The middle value; of an even number of values the upper of the two. Needs one value or more.
[[nodiscard]] inline double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace porepack::inline core
