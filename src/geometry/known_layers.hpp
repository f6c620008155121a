// The layers of an image that are kept where a part of it is enough.
#pragma once

#include <vector>

#include "core/interval.hpp"
#include "geometry/grid.hpp"

namespace porepack::inline geometry {

/// Which layers along z of a grid are kept, and in which place. Cells are kept layer by layer, in the order of the grid.
class KnownLayers {
public:
    /// All of them.
    explicit KnownLayers(const Grid& grid);
    /// Those between these heights, and two more at each end. Beyond a periodic side they continue at the other one; otherwise the
    /// outermost layers stand for what lies beyond them.
    KnownLayers(const Grid& grid, const std::vector<core::Interval>& heights_m, bool periodic);

    [[nodiscard]] bool has(int layer) const { return known_[static_cast<std::size_t>(layer)]; }
    /// Place of a layer; of one that is not kept, that of the last one below it.
    [[nodiscard]] int place(int layer) const { return place_[static_cast<std::size_t>(layer)]; }
    [[nodiscard]] int number() const { return number_; }
    /// The values of the cells in these layers, from those of `from`.
    template <typename Value>
    [[nodiscard]] std::vector<Value> values(const Grid& grid, const KnownLayers& from, const std::vector<Value>& all) const {
        const auto area = static_cast<std::ptrdiff_t>(grid.index(0, 0, 1));
        std::vector<Value> kept;
        kept.reserve(static_cast<std::size_t>(number_) * static_cast<std::size_t>(area));
        for (int layer = 0; layer < grid.cells[2]; ++layer) {
            if (!has(layer)) continue;
            const auto first = all.begin() + from.place(layer) * area;
            kept.insert(kept.end(), first, first + area);
        }
        return kept;
    }

private:
    void set_places();

    std::vector<bool> known_;
    std::vector<int> place_;
    int number_ = 0;
};

}  // namespace porepack::inline geometry
