// Pictures of a vertical slice of an image. Only for the sources of stages.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/files.hpp"
#include "geometry/grid.hpp"
#include "io/image.hpp"

namespace porepack::stages {

/// Pictures of the vertical slice through the middle, z up; pixels of a voxel's size, enlarged for small images.
class SlicePicture {
public:
    explicit SlicePicture(const geometry::Grid& grid) : grid_(grid), zoom_(std::max(1, 600 / std::max(grid.cells[0], 1))) {
        pixels_.assign(static_cast<std::size_t>(width() * height() * 3), 0);
    }
    [[nodiscard]] int row() const { return grid_.cells[1] / 2; }
    /// `paint`: colour of voxel (i, k) of the slice; `edge`: its phase, for the outlines between different ones.
    template <typename Paint, typename Edge>
    void write(const core::Path& file, const Paint& paint, const Edge& edge, const std::array<std::uint8_t, 3>& line) {
        for (int y = 0; y < height(); ++y)
            for (int x = 0; x < width(); ++x) {
                const int i = x / zoom_, k = y / zoom_;
                std::array<std::uint8_t, 3> colour = paint(i, k);
                const bool at_right = x % zoom_ == zoom_ - 1 && i + 1 < grid_.cells[0] && edge(i, k) != edge(i + 1, k);
                const bool at_top = y % zoom_ == zoom_ - 1 && k + 1 < grid_.cells[2] && edge(i, k) != edge(i, k + 1);
                if (at_right || at_top) colour = line;
                std::copy(colour.begin(), colour.end(), pixels_.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * width() + x));
            }
        io::write_colour_png(file, width(), height(), pixels_);
    }

private:
    [[nodiscard]] int width() const { return grid_.cells[0] * zoom_; }
    [[nodiscard]] int height() const { return grid_.cells[2] * zoom_; }
    const geometry::Grid& grid_;
    int zoom_;
    std::vector<std::uint8_t> pixels_;
};

/// Of a solid fraction.
inline std::array<std::uint8_t, 3> gray_colour(double fraction) {
    const auto value = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(0.1 + 0.75 * fraction, 0.0, 1.0)));
    return {value, value, value};
}

}  // namespace porepack::stages
