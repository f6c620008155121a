// Pictures of a vertical slice of an image. Only for the sources of this folder.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "analysis/outcome.hpp"
#include "geometry/grid.hpp"

namespace porepack::analysis {

using Colour = std::array<std::uint8_t, 3>;

/// The layer of voxels that slice_picture() shows.
inline int middle_row(const geometry::Grid& grid) {
    return grid.cells[1] / 2;
}

/// The vertical slice through the middle, z up; pixels of a voxel's size, enlarged for small images. `paint`: colour of voxel (i, k) of the
/// slice; `edge`: its phase, for the outlines between different ones.
template <typename Paint, typename Edge>
[[nodiscard]] Picture slice_picture(const std::string& file, const geometry::Grid& grid, const Paint& paint, const Edge& edge,
                                    const Colour& line) {
    const int zoom = std::max(1, 600 / std::max(grid.cells[0], 1));
    Picture picture{.file = file, .width = grid.cells[0] * zoom, .height = grid.cells[2] * zoom};
    picture.pixels.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3);
    auto pixel = picture.pixels.begin();
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const int i = x / zoom, k = y / zoom;
            Colour colour = paint(i, k);
            const bool at_right = x % zoom == zoom - 1 && i + 1 < grid.cells[0] && edge(i, k) != edge(i + 1, k);
            const bool at_top = y % zoom == zoom - 1 && k + 1 < grid.cells[2] && edge(i, k) != edge(i, k + 1);
            if (at_right || at_top) colour = line;
            pixel = std::copy(colour.begin(), colour.end(), pixel);
        }
    return picture;
}

/// Of a solid fraction.
inline Colour gray_colour(double fraction) {
    const auto value = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(0.1 + 0.75 * fraction, 0.0, 1.0)));
    return {value, value, value};
}

}  // namespace porepack::analysis
