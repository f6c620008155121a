#include "lbm/slabs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/error.hpp"
#include "lbm/uses.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::lbm {
namespace {

int cut_of(double height, int layers) {
    return static_cast<int>(std::lround(height * layers));
}

// The same box with voxels about three times as large.
Grid coarser(Grid grid) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int cells = std::max(1, (grid.cells[axis] + 1) / 3);
        grid.spacing_m[axis] *= static_cast<double>(grid.cells[axis]) / cells;
        grid.cells[axis] = cells;
    }
    return grid;
}

// Of each layer, counted by the part to which an equal share of the layers belongs.
std::vector<double> pore_cells_of_layers(const PoreSpace& space, const Grid& whole, const Communicator& parts) {
    const int layers = whole.cells[2], first = cut_of(static_cast<double>(parts.part()) / parts.parts(), layers),
              end = cut_of(static_cast<double>(parts.part() + 1) / parts.parts(), layers);
    std::vector<double> mine;
    constexpr int at_once = 32;  // layers whose phases are in memory
    for (int low = first; low < end; low += at_once) {
        const PhaseImage image = space.phases_on(whole.slab_of(low, std::min(low + at_once, end), false).without_halo());
        const std::size_t area = image.grid.index(0, 0, 1);
        for (std::size_t cell = 0; cell < image.phase.size(); cell += area)
            mine.push_back(static_cast<double>(std::count_if(image.phase.begin() + static_cast<std::ptrdiff_t>(cell),
                                                             image.phase.begin() + static_cast<std::ptrdiff_t>(cell + area),
                                                             [](std::uint8_t phase) { return phase == Phase::pore; })));
    }
    std::vector<double> all;
    for (const Bytes& of_part : parts.gather(core::bytes_of(mine)))
        for (const double count : list_of<double>(of_part)) all.push_back(count);
    return all;
}

// Of the cuts between parts with equal shares of the pores, but no slab thinner than the grid allows.
std::vector<double> heights_of_cuts(const std::vector<double>& pores, int number, int layers) {
    const double total = std::accumulate(pores.begin(), pores.end(), 0.0), thinnest = (min_layers + 0.01) / layers;
    std::vector<double> heights = {0.0};
    double below = 0.0;
    std::size_t layer = 0;
    for (int part = 1; part < number; ++part) {
        const double wanted = total * part / number;
        while (layer < pores.size() && below + pores[layer] < wanted) below += pores[layer++];
        const double share = layer < pores.size() && pores[layer] > 0.0 ? (wanted - below) / pores[layer] : 0.0;
        heights.push_back((static_cast<double>(layer) + share) / static_cast<double>(pores.size()));
    }
    heights.push_back(1.0);
    // Thick enough, from below and then from above; where all are as thin as possible, equal ones.
    const auto count = heights.size() - 1;
    if (thinnest * number > 1.0) {
        for (std::size_t cut = 0; cut <= count; ++cut) heights[cut] = static_cast<double>(cut) / number;
        return heights;
    }
    for (std::size_t cut = 1; cut < count; ++cut) heights[cut] = std::max(heights[cut], heights[cut - 1] + thinnest);
    for (std::size_t cut = count - 1; cut > 0; --cut) heights[cut] = std::min(heights[cut], heights[cut + 1] - thinnest);
    return heights;
}

}  // namespace

UserError too_many_parts(long parts, long most) {
    return UserError(fmt::format("{} ranks are too many: a rank needs {} layers of voxels of the coarsest grid", parts, min_layers),
                     {.where = "--ranks", .allowed = fmt::format("up to {}", most)});
}

SlabCuts::SlabCuts(const PoreSpace& space, const Grid& grid, const Communicator& parts) {
    const int number = parts.parts();
    if (number == 1) return;
    if (number > max_parts(grid.cells[2])) throw too_many_parts(number, max_parts(grid.cells[2]));
    heights_ = heights_of_cuts(pore_cells_of_layers(space, space.own_grid() ? grid : coarser(grid), parts), number, grid.cells[2]);
}

std::vector<SlabShare> slab_shares(const PoreSpace& space, const Grid& grid, int parts, const Communicator& counted_by) {
    const std::vector<double> pores = pore_cells_of_layers(space, space.own_grid() ? grid : coarser(grid), counted_by);
    const std::vector<double> heights = heights_of_cuts(pores, parts, grid.cells[2]);
    const double total = std::max(1.0, std::accumulate(pores.begin(), pores.end(), 0.0)), layers = static_cast<double>(pores.size());
    std::vector<SlabShare> shares(static_cast<std::size_t>(parts), {0.0, 0.0});
    for (std::size_t part = 0; part < shares.size(); ++part) {
        shares[part].height = heights[part + 1] - heights[part];
        for (std::size_t layer = 0; layer < pores.size(); ++layer) {
            const double low = static_cast<double>(layer) / layers, high = static_cast<double>(layer + 1) / layers,
                         inside = std::min(high, heights[part + 1]) - std::max(low, heights[part]);
            shares[part].pores += std::max(0.0, inside) * layers * pores[layer] / total;
        }
    }
    return shares;
}

Grid SlabCuts::slab_of(const Grid& whole, bool periodic, const Communicator& parts) const {
    const auto part = static_cast<std::size_t>(parts.part());
    return whole.slab_of(cut_of(heights_[part], whole.cells[2]), cut_of(heights_[part + 1], whole.cells[2]), periodic);
}

}  // namespace porepack::lbm
