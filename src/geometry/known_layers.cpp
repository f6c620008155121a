#include "geometry/known_layers.hpp"

#include <algorithm>
#include <cmath>

namespace porepack::inline geometry {

KnownLayers::KnownLayers(const Grid& grid) : known_(static_cast<std::size_t>(grid.cells[2]), true) {
    set_places();
}

KnownLayers::KnownLayers(const Grid& grid, const std::vector<core::Interval>& heights_m, bool periodic)
    : known_(static_cast<std::size_t>(grid.cells[2]), false) {
    const long layers = grid.cells[2];
    const auto layer_at = [&](double z) { return std::lround(std::floor((z - grid.origin_m[2]) / grid.spacing_m[2])); };
    for (const core::Interval& part : heights_m) {
        long low = layer_at(part.low) - 2, high = layer_at(part.high) + 2;
        if (!periodic) {
            low = std::clamp(low, 0L, layers - 1);
            high = std::clamp(high, 0L, layers - 1);
        }
        high = std::min(high, low + layers - 1);
        for (long layer = low; layer <= high; ++layer) known_[static_cast<std::size_t>(((layer % layers) + layers) % layers)] = true;
    }
    set_places();
}

void KnownLayers::set_places() {
    place_.reserve(known_.size());
    for (const bool known : known_) {
        number_ += known ? 1 : 0;
        place_.push_back(std::max(0, number_ - 1));
    }
}

}  // namespace porepack::inline geometry
