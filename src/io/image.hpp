// Images on regular grids for ParaView (.vti): cell data, in metres. The only room that knows VTK.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack {

/// A regular grid of cells; cell (i, j, k) has index (k ny + j) nx + i and its centre at origin + (i + 1/2, ...) spacing.
struct Grid {
    std::array<int, 3> cells = {0, 0, 0};
    std::array<double, 3> origin_m = {0, 0, 0};
    std::array<double, 3> spacing_m = {1, 1, 1};
    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cells[2]);
    }
    [[nodiscard]] std::size_t index(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(cells[1]) + static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(cells[0]) +
               static_cast<std::size_t>(i);
    }
    [[nodiscard]] double centre(int axis, int i) const {
        const auto a = static_cast<std::size_t>(axis);
        return origin_m[a] + (i + 0.5) * spacing_m[a];
    }
};

/// Phases of a cell.
enum Phase : std::uint8_t { grain = 0, pore = 1, outside = 2 };

/// A phase image with notes (for instance the container) that are kept in the file as field data.
struct PhaseImage {
    Grid grid;
    std::vector<std::uint8_t> phase;
    std::map<std::string, std::string> notes;
};

void write_phase_image(const Path& path, const PhaseImage& image);
/// Throws UserError when the file is no image, has no cell data `phase` of uint8, or other values than 0, 1, 2.
[[nodiscard]] PhaseImage read_phase_image(const Path& path);

/// Velocity in m/s (3 numbers a cell) and pressure in Pa; single precision.
struct FlowImage {
    Grid grid;
    std::vector<float> velocity_m_per_s;
    std::vector<float> pressure_Pa;
    std::vector<std::uint8_t> phase;
    std::map<std::string, std::string> notes;
};
void write_flow_image(const Path& path, const FlowImage& image);
/// Throws UserError as above; NaN in the velocity is named with its cell.
[[nodiscard]] FlowImage read_flow_image(const Path& path);

/// 8-bit gray PNG; row 0 of `pixels` is the bottom row (y up).
void write_gray_png(const Path& path, int width, int height, std::span<const std::uint8_t> pixels);
[[nodiscard]] std::vector<std::uint8_t> read_gray_png(const Path& path, int& width, int& height);
/// 8-bit RGB PNG, 3 numbers a pixel, row 0 at the bottom.
void write_colour_png(const Path& path, int width, int height, std::span<const std::uint8_t> pixels);

}  // namespace porepack
