#include "geometry/known_layers.hpp"

#include <algorithm>
#include <cmath>

namespace porepack::geometry {

KnownLayers::KnownLayers(const Grid& grid) : known_(static_cast<std::size_t>(grid.cells[2]), true) {
    set_places();
}

KnownLayers::KnownLayers(const Grid& grid, const std::vector<core::Interval>& heights_m)
    : known_(static_cast<std::size_t>(grid.cells[2]), false) {
    const long layers = grid.cells[2];
    const auto layer_at = [&](double z) { return std::lround(std::floor((z - grid.origin_m[2]) / grid.spacing_m[2])); };
    for (const core::Interval& part : heights_m) {
        const long low = layer_at(part.low) - 2, high = std::min(layer_at(part.high) + 2, low + layers - 1);
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

}  // namespace porepack::geometry
