#include "scans/doubts.hpp"
#include "scans/uses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace porepack::scans {
namespace {

// Visits all cells of one layer across `axis`.
template <typename Visit>
void for_layer(const PhaseImage& image, int axis, int layer, const Visit& visit) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<int, 3> at{};
    at[static_cast<std::size_t>(axis)] = layer;
    for (int j = 0; j < image.grid.cells[static_cast<std::size_t>(v)]; ++j)
        for (int i = 0; i < image.grid.cells[static_cast<std::size_t>(u)]; ++i) {
            at[static_cast<std::size_t>(u)] = i;
            at[static_cast<std::size_t>(v)] = j;
            visit(image.phase[image.grid.index(at[0], at[1], at[2])], i, j);
        }
}

// How many of the outermost layers are pores only.
int border(const PhaseImage& image, int axis, bool low) {
    const int count = image.grid.cells[static_cast<std::size_t>(axis)];
    for (int n = 0; n < count; ++n) {
        bool pores = false, others = false;
        for_layer(image, axis, low ? n : count - 1 - n, [&](std::uint8_t phase, int, int) {
            pores = pores || phase == Phase::pore;
            others = others || phase == Phase::grain;
        });
        if (others || !pores) return n;
    }
    return 0;  // all is pore: said elsewhere
}

// Everything outside the circle that the image encloses is pore, at every height, and not everything inside.
bool is_round(const PhaseImage& image) {
    const Grid& grid = image.grid;
    const double width = grid.cells[0], depth = grid.cells[1];
    if (std::abs(width - depth) > 0.05 * width || std::min(width, depth) < 8) return false;
    const double radius = 0.5 * std::min(width, depth) + 0.5;
    double corners = 0.0, corner_pores = 0.0, inside = 0.0, inside_pores = 0.0;
    for (int k = 0; k < grid.cells[2]; ++k)
        for_layer(image, 2, k, [&](std::uint8_t phase, int i, int j) {
            const bool out = std::hypot(i + 0.5 - 0.5 * width, j + 0.5 - 0.5 * depth) > radius;
            (out ? corners : inside) += phase == Phase::outside ? 0.0 : 1.0;
            (out ? corner_pores : inside_pores) += phase == Phase::pore ? 1.0 : 0.0;
        });
    return corners > 0.0 && corner_pores > 0.999 * corners && inside_pores < 0.95 * inside;
}

// Mean length of the runs of pores, in voxels, along the axis along which they are shortest.
std::pair<double, int> narrowest(const PhaseImage& image) {
    const Grid& grid = image.grid;
    const std::array<std::size_t, 3> stride = {1, grid.index(0, 1, 0), grid.index(0, 0, 1)};
    std::array<double, 3> ends{};
    double pores = 0.0;
    for (int k = 0; k < grid.cells[2]; ++k)
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i) {
                const std::size_t at = grid.index(i, j, k);
                if (image.phase[at] != Phase::pore) continue;
                pores += 1.0;
                const std::array<int, 3> place = {i, j, k};
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (place[axis] + 1 == grid.cells[axis] || image.phase[at + stride[axis]] != Phase::pore) ends[axis] += 1.0;
            }
    const auto worst_axis = static_cast<int>(std::max_element(ends.begin(), ends.end()) - ends.begin());
    const double count = ends[static_cast<std::size_t>(worst_axis)];
    return {count > 0.0 ? pores / count : 0.0, worst_axis};
}

}  // namespace

std::vector<std::string> doubts_of(const PhaseImage& image) {
    std::vector<std::string> doubts;
    std::string borders;
    for (const int axis : {0, 1, 2}) {
        const int first = border(image, axis, true), last = border(image, axis, false);
        if (first + last > 0) borders += fmt::format("{}{} and {} along {}", borders.empty() ? "" : ", ", first, last, "xyz"[axis]);
    }
    if (!borders.empty())
        doubts.push_back(fmt::format(
            "the outermost layers are pores only ({}): a border around the sample? Then crop it (porepack image crop)", borders));
    if (is_round(image))
        doubts.emplace_back(
            "everything outside the circle that fits into the image is pore: is it a round sample? "
            "Then --container cylinder:D,H leaves the corners out");
    constexpr double narrow = 2.5;
    if (const auto [width, axis] = narrowest(image); width > 0.0 && width < narrow)
        doubts.push_back(fmt::format(
            "the pores are {:.1f} voxels wide along {}, on average: k of such pores may be tens of per cent too high; use a finer image",
            width, "xyz"[axis]));
    return doubts;
}

}  // namespace porepack::scans
