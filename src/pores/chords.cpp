#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "pores/pores.hpp"

namespace porepack::pores {
using namespace packing;
using namespace vessels;
namespace {

Chords summarised(std::vector<double> lengths) {
    std::sort(lengths.begin(), lengths.end());
    Chords chords{.lengths_m = std::move(lengths)};
    if (chords.lengths_m.empty()) return chords;
    const double count = static_cast<double>(chords.lengths_m.size());
    chords.mean_m = std::accumulate(chords.lengths_m.begin(), chords.lengths_m.end(), 0.0) / count;
    double squares = 0.0;
    for (const double length : chords.lengths_m) squares += (length - chords.mean_m) * (length - chords.mean_m);
    chords.deviation_m = std::sqrt(squares / count);
    return chords;
}

}  // namespace

Chords chords_of_voxels(const PhaseImage& image, int axis, bool periodic) {
    const Grid& grid = image.grid;
    const auto a = static_cast<std::size_t>(axis), b = (a + 1) % 3, c = (a + 2) % 3;
    std::vector<double> lengths;
    std::array<int, 3> at{};
    const int n = grid.cells[a];
    for (at[c] = 0; at[c] < grid.cells[c]; ++at[c])
        for (at[b] = 0; at[b] < grid.cells[b]; ++at[b]) {
            const auto phase = [&](int i) {
                at[a] = i % n;
                return image.phase[grid.index(at[0], at[1], at[2])];
            };
            // From a wall to the next one; a periodic row is followed once round, from its first wall.
            int first = 0;
            while (first < n && phase(first) == Phase::pore) ++first;
            if (first == n) continue;
            int run = 0;
            for (int i = first; i <= (periodic ? first + n : n - 1); ++i) {
                if (phase(i) == Phase::pore) {
                    ++run;
                } else {
                    if (run > 0) lengths.push_back(run * grid.spacing_m[a]);
                    run = 0;
                }
            }
        }
    return summarised(std::move(lengths));
}

Chords vertical_chords(const Solid& solid, const Container& container, const Section& section, long lines) {
    const shapes::Vec3 low = container.low(), size = container.high() - low;
    const double step = std::sqrt(size.x() * size.y() / static_cast<double>(lines));
    std::vector<double> lengths;
    std::vector<Interval> parts;
    for (double y = low.y() + 0.5 * step; y < low.y() + size.y(); y += step)
        for (double x = low.x() + 0.5 * step; x < low.x() + size.x(); x += step) {
            if (!container.contains_column(x, y)) continue;
            solid.column(x, y, parts);
            if (container.periodic()[2]) {
                std::vector<Interval> once;
                for (const Interval& part : parts)
                    if (part.high > 0.0 && part.low < size.z()) once.push_back({std::max(0.0, part.low), std::min(size.z(), part.high)});
                parts.swap(once);
                if (!parts.empty()) parts.push_back({parts.front().low + size.z(), parts.front().high + size.z()});
            }
            for (std::size_t p = 0; p + 1 < parts.size(); ++p)
                if (const bool whole = container.periodic()[2] || (parts[p].high >= section.z0_m && parts[p + 1].low <= section.z1_m);
                    whole && parts[p + 1].low > parts[p].high)
                    lengths.push_back(parts[p + 1].low - parts[p].high);
        }
    return summarised(std::move(lengths));
}

}  // namespace porepack::pores
