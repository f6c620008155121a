// Images on regular grids for ParaView (.vti): cell data, in metres. The only folder that uses VTK.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/communicator.hpp"
#include "core/files.hpp"
#include "geometry/gray_image.hpp"

namespace porepack::io {

void write_phase_image(const core::Path& path, const geometry::PhaseImage& image);

/// Cell data `solid_fraction`, single precision.
void write_gray_image(const core::Path& path, const geometry::GrayImage& image);

/// Cell data `label`, 32 bits; 0 is no grain.
void write_label_image(const core::Path& path, const geometry::Grid& grid, const std::vector<std::uint32_t>& label);

/// By all parts of the computation together, each the layers that it has; the bytes do not depend on their number. Each has its layers
/// compressed in memory, some 10 bytes per pore cell.
void write_flow_image(const core::Path& path, const geometry::LayeredFlow& flow, const core::Communicator& parts = core::no_communicator());
/// Throws UserError when the file is not an image or has no such cell data; for NaN in the velocity with the index of the cell.
[[nodiscard]] geometry::FlowImage read_flow_image(const core::Path& path);

/// 8-bit gray PNG; row 0 of `pixels` is the bottom row (y up).
void write_gray_png(const core::Path& path, int width, int height, std::span<const std::uint8_t> pixels);
[[nodiscard]] std::vector<std::uint8_t> read_gray_png(const core::Path& path, int& width, int& height);
/// 8-bit RGB PNG, 3 numbers per pixel, row 0 at the bottom.
void write_colour_png(const core::Path& path, int width, int height, std::span<const std::uint8_t> pixels);

}  // namespace porepack::io
