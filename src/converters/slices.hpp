// Slices of a packing as images, for programs that read stacks, and for the paper's tortuosity.
#pragma once

#include <cstdint>
#include <vector>

#include "core/files.hpp"
#include "geometry/grid.hpp"
#include "packing/grains.hpp"
#include "packing/section.hpp"

namespace porepack::converters {

/// A stack of gray images slice_0000.png (grain 0, pore 255, outside 128) from z0 to z1, with the coordinates in slices.json.
/// Returns the number of slices.
int write_slices(const core::Path& folder, const geometry::Solid& solid, const vessels::Container& container,
                 const packing::Section& section, double spacing_m, double pixel_m);

struct SliceStack {
    geometry::Grid grid;  ///< spacing in z is the distance of the slices, which lie at mid-height of their cells
    std::vector<std::uint8_t> phase;
    vessels::Container container;
    packing::Section section;
};
/// Throws UserError when slices.json or an image is missing or differs in size.
[[nodiscard]] SliceStack read_slices(const core::Path& folder);

}  // namespace porepack::converters
