#include <algorithm>
#include <array>

#include "core/parallel.hpp"
#include "pores/pores.hpp"

namespace porepack::pores {

Correlation correlate(const PhaseImage& image, const std::array<bool, 3>& periodic, double farthest_m) {
    const Grid& grid = image.grid;
    const double h = grid.spacing_m[0];
    int farthest = static_cast<int>(farthest_m / h);
    for (std::size_t a = 0; a < 3; ++a) farthest = std::min(farthest, grid.cells[a] / 2);
    Correlation found;
    for (int r = 0; r <= farthest; ++r) found.distance_m.push_back(r * h);
    for (std::size_t a = 0; a < 3; ++a) {
        found.probability[a].resize(found.distance_m.size());
        found.differing[a].resize(found.distance_m.size());
        const std::array<std::size_t, 3> steps = {1, static_cast<std::size_t>(grid.cells[0]), grid.index(0, 0, 1)};
        const std::size_t n = static_cast<std::size_t>(grid.cells[a]), step = steps[a];
        parallel_for(found.distance_m.size(), [&](std::size_t r) {
            std::size_t both = 0, one = 0, pairs = 0;
            for (std::size_t cell = 0; cell < image.phase.size(); ++cell) {
                if (image.phase[cell] == Phase::outside) continue;
                const std::size_t place = cell / step % n;
                if (place + r >= n && !periodic[a]) continue;
                const std::size_t other = place + r < n ? cell + r * step : cell + r * step - n * step;
                if (image.phase[other] == Phase::outside) continue;
                ++pairs;
                both += image.phase[cell] == Phase::pore && image.phase[other] == Phase::pore ? 1 : 0;
                one += image.phase[cell] != image.phase[other] ? 1 : 0;
            }
            found.differing[a][r] = pairs > 0 ? static_cast<double>(one) / static_cast<double>(pairs) : 0.0;
            found.probability[a][r] = pairs > 0 ? static_cast<double>(both) / static_cast<double>(pairs) : 0.0;
        });
    }
    return found;
}

// S2 = porosity - S r / 4 + O(r^2) (Debye, Anderson & Brumberger 1957); the two ends differ with twice the probability porosity - S2,
// counted on the same pairs, so that the sides of the section have no effect.
double Correlation::surface_per_volume_m() const {
    if (distance_m.size() < 3) return 0.0;
    double slope = 0.0;
    for (const auto& d : differing) slope += (4.0 * d[1] - d[2]) / (4.0 * distance_m[1]) / 3.0;
    return 4.0 * slope;
}

}  // namespace porepack::pores
