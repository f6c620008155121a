// Poses in a scan that is larger than memory: slab after slab.
#pragma once

#include <functional>
#include <vector>

#include "scans/refine.hpp"

namespace porepack::scans {

/// Solid fractions of `count` layers from `first` on, in the place that they have in the whole scan.
using ReadLayers = std::function<geometry::GrayImage(int first, int count)>;

/// Memory of the thinnest slab that refine_slabs() can work with: a layer of grains with all that they reach below and above.
[[nodiscard]] double smallest_slab_bytes(const geometry::Grid& grid, const std::vector<ShapePoints>& shapes, double blur_m);

/// refine() for grains that are known well, for instance from a binned image: each slab of layers fits the grains whose middle it holds;
/// neighbours from beyond it stay. Common parameters are means over the slabs, weighted by their grains. `grid`: of the whole scan.
/// A slab takes at most `slab_bytes`, or the smallest that is possible.
[[nodiscard]] Refined refine_slabs(const ReadLayers& read, const geometry::Grid& grid, const vessels::Container& container,
                                   const std::vector<ShapePoints>& shapes, const Refined& start, double slab_bytes);

}  // namespace porepack::scans
