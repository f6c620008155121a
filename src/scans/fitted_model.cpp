#include "scans/fitted_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/parallel.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {

double inside_of_edge(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

std::vector<Capsule> resized(const std::vector<Capsule>& capsules, double radius_change_m, double length_factor) {
    std::vector<Capsule> all;
    for (const Capsule& capsule : capsules)
        all.push_back({length_factor * capsule.a, length_factor * capsule.b, capsule.radius + radius_change_m});
    return all;
}

std::vector<std::uint8_t> rendered(const Grid& grid, const std::vector<ShapePoints>& shapes, const Refined& found, double blur_m) {
    std::vector<std::uint8_t> fractions(grid.size(), 0);
    const double reach = 4.0 * blur_m;
    for (const FittedGrain& grain : found.grains) {
        const Common::OfShape& sizes = found.common.shapes[grain.shape];
        const auto capsules =
            placed(resized(shapes[grain.shape].capsules, sizes.radius_change_m.value, sizes.length_factor.value), grain.pose);
        Bounds bounds;
        for (const Capsule& capsule : capsules) add(bounds, capsule);
        std::array<int, 3> low{}, high{};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            low[a] = std::max(0, static_cast<int>(std::floor((bounds.low[axis] - reach - grid.origin_m[a]) / grid.spacing_m[a])));
            high[a] =
                std::min(grid.cells[a], static_cast<int>(std::ceil((bounds.high[axis] + reach - grid.origin_m[a]) / grid.spacing_m[a])));
        }
        if (low[2] >= high[2]) continue;
        parallel_for(static_cast<std::size_t>(high[2] - low[2]), [&](std::size_t layer) {
            const int k = low[2] + static_cast<int>(layer);
            for (int j = low[1]; j < high[1]; ++j)
                for (int i = low[0]; i < high[0]; ++i) {
                    const double s = signed_distance(capsules, Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k)));
                    if (s > reach) continue;
                    std::uint8_t& fraction = fractions[grid.index(i, j, k)];
                    fraction = static_cast<std::uint8_t>(std::min(255L, fraction + std::lround(255.0 * inside_of_edge(-s / blur_m))));
                }
        });
    }
    return fractions;
}

}  // namespace porepack::scans
