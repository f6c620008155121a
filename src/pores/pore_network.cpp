// Where pores are joined: voxels are opened from the widest place to the narrowest, and what meets is joined.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "pores/pores.hpp"

namespace porepack::pores {
namespace {

// Parts that become one part when they are joined.
class Parts {
public:
    explicit Parts(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
    std::size_t of(std::size_t node) {
        while (parent_[node] != node) {
            parent_[node] = parent_[parent_[node]];
            node = parent_[node];
        }
        return node;
    }
    void join(std::size_t p, std::size_t q) { parent_[of(p)] = static_cast<std::uint32_t>(of(q)); }

private:
    std::vector<std::uint32_t> parent_;
};

std::vector<std::uint32_t> from_widest(const PhaseImage& image, const std::vector<float>& distance_m) {
    std::vector<std::uint32_t> order;
    for (std::size_t cell = 0; cell < image.phase.size(); ++cell)
        if (image.phase[cell] == Phase::pore) order.push_back(static_cast<std::uint32_t>(cell));
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) { return distance_m[p] > distance_m[q]; });
    return order;
}

}  // namespace

std::optional<double> critical_diameter_m(const PhaseImage& image, const std::vector<float>& distance_m, int axis) {
    const auto a = static_cast<std::size_t>(axis);
    const Grid& grid = image.grid;
    const std::size_t cells = grid.size(), first_end = cells, last_end = cells + 1;  // nodes that stand for the two ends
    const std::array<std::size_t, 3> step = {1, static_cast<std::size_t>(grid.cells[0]), grid.index(0, 0, 1)};
    Parts parts(cells + 2);
    std::vector<bool> open(cells, false);
    for (const std::uint32_t cell : from_widest(image, distance_m)) {
        open[cell] = true;
        grid.for_neighbours(cell, [&](std::size_t other) {
            if (open[other]) parts.join(cell, other);
        });
        const std::size_t place = cell / step[a] % static_cast<std::size_t>(grid.cells[a]);
        if (place == 0) parts.join(cell, first_end);
        if (place + 1 == static_cast<std::size_t>(grid.cells[a])) parts.join(cell, last_end);
        if (parts.of(first_end) == parts.of(last_end)) return 2.0 * static_cast<double>(distance_m[cell]);
    }
    return std::nullopt;
}

// Voxels are visited from the widest to the narrowest, as if water fell over a relief of distances. A voxel without a pore beside it is a
// new maximum and opens a pore. One beside a pore joins it. One between two pores is the widest place between them, their throat; if it is
// nearly as wide as the narrower of the two (one_pore), the two are one pore with a rough middle, and are joined.
PoreNetwork pore_network(const PhaseImage& image, const std::vector<float>& distance_m, const std::array<bool, 3>& periodic) {
    constexpr auto none = std::numeric_limits<std::uint32_t>::max();
    constexpr double one_pore = 0.9;
    const Grid& grid = image.grid;
    std::vector<std::uint32_t> pore_of(grid.size(), none);
    std::vector<float> widest;  // of each pore when it was opened, at its first voxel
    std::vector<std::size_t> first_cell;
    Parts joined(grid.size());
    std::map<std::pair<std::uint32_t, std::uint32_t>, float> widest_between;
    const auto root = [&](std::uint32_t pore) { return static_cast<std::uint32_t>(joined.of(pore)); };
    for (const std::uint32_t cell : from_widest(image, distance_m)) {
        const float here = distance_m[cell];
        std::uint32_t own = none;
        std::array<std::uint32_t, 6> met{};
        std::size_t count = 0;
        const auto meet = [&](std::size_t other) {
            if (pore_of[other] != none) met[count++] = root(pore_of[other]);
        };
        grid.for_neighbours(cell, meet, periodic);
        for (std::size_t i = 0; i < count; ++i)
            if (own == none || widest[met[i]] > widest[own]) own = met[i];
        if (own == none) {
            own = static_cast<std::uint32_t>(widest.size());
            widest.push_back(here);
            first_cell.push_back(cell);
        }
        pore_of[cell] = own;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t one = root(met[i]), other = root(own);
            if (one == other) continue;
            if (static_cast<double>(here) >= one_pore * static_cast<double>(std::min(widest[one], widest[other]))) {
                const bool first_is_wider = widest[one] >= widest[other];
                joined.join(first_is_wider ? other : one, first_is_wider ? one : other);
            } else {
                widest_between.try_emplace({std::min(one, other), std::max(one, other)}, here);
            }
        }
    }
    PoreNetwork network;
    std::map<std::uint32_t, std::size_t> place;
    for (std::uint32_t pore = 0; pore < widest.size(); ++pore)
        if (root(pore) == pore) {
            place[pore] = network.pores.size();
            const std::array<int, 3> at = grid.place(first_cell[pore]);
            network.pores.push_back({.diameter_m = 2.0 * static_cast<double>(widest[pore]),
                                     .centre_m = {grid.centre(0, at[0]), grid.centre(1, at[1]), grid.centre(2, at[2])}});
        }
    std::map<std::pair<std::size_t, std::size_t>, float> throats;  // pores that were joined later have the wider of their throats
    for (const auto& [pair, width] : widest_between) {
        const std::size_t one = place[root(pair.first)], other = place[root(pair.second)];
        if (one == other) continue;
        float& widest_throat = throats[{std::min(one, other), std::max(one, other)}];
        widest_throat = std::max(widest_throat, width);
    }
    for (const auto& [pair, width] : throats)
        network.throats.push_back({.first = pair.first, .second = pair.second, .diameter_m = 2.0 * static_cast<double>(width)});
    const auto last = static_cast<std::size_t>(grid.cells[2]) - 1, layer = grid.index(0, 0, 1);
    for (std::size_t cell = 0; cell < pore_of.size(); ++cell) {
        if (pore_of[cell] == none) continue;
        PoreNetwork::Pore& pore = network.pores[place[root(pore_of[cell])]];
        pore.volume_m3 += grid.spacing_m[0] * grid.spacing_m[1] * grid.spacing_m[2];
        pore.cut = pore.cut || (!periodic[2] && (cell / layer == 0 || cell / layer == last));
    }
    return network;
}

double katz_thompson_m2(double critical_diameter_m, double relative_diffusivity) {
    constexpr double tubes = 32.0, slits = 12.0;
    return critical_diameter_m * critical_diameter_m / std::sqrt(tubes * slits) * relative_diffusivity;
}

}  // namespace porepack::pores
