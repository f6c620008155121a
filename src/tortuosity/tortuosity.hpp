// Tortuosities. Each has a name of its own, because they are different numbers (docs/theory.md).
#pragma once

#include <functional>
#include <optional>

#include "converters/voxels.hpp"
#include "tortuosity/config.hpp"

namespace porepack {

/// The paper's dot method (2.1.3): dots on a square grid, the same on every slice; a dot inside a grain moves to the
/// closest void point of its slice; a path joins its points from slice to slice.
struct GeometricPaperResult {
    double value = 0.0;           ///< mean over the paths of path length / straight length
    double standard_error = 0.0;  ///< of the mean, from the scatter between paths
    double standard_deviation = 0.0;
    long paths = 0;
    long slices = 0;
    double rejections_per_point = 0.0;
};

/// With exact geometry: the closest void point is found on rays in the slice's plane (exact intervals), minimised over the
/// direction to 1e-9 of the grain size.
[[nodiscard]] GeometricPaperResult geometric_paper_exact(const Grains& grains, const Container& container, const Section& section,
                                                         const TortuosityConfig& config);
/// On pictures: the closest void pixel's centre. The result depends on the pixel (it grows with it).
[[nodiscard]] GeometricPaperResult geometric_paper_on_slices(const SliceStack& slices, const TortuosityConfig& config);

/// <|u|> / <u_axis> over the section's fluid (Duda, Koza & Matyka 2011). Throws NumericalError when nothing flows along the axis.
[[nodiscard]] double hydraulic_tortuosity(const FlowImage& flow, const Section& section, int axis);

}  // namespace porepack
