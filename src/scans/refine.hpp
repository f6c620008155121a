// Poses by least squares on the gray values themselves.
#pragma once

#include <limits>
#include <vector>

#include "geometry/gray_image.hpp"
#include "packing/packing.hpp"
#include "scans/estimate.hpp"
#include "scans/shape_points.hpp"

namespace porepack::scans {

/// What is the same for all grains of an image. A grain's gray value at signed distance s from its surface, whose mean curvature there is
/// H: pores + (solid - pores) Phi(-s / blur - blur H), by which a surface that blur has moved inward is where it was.
struct Common {
    Estimate pores{0.0}, solid{1.0};  ///< solid fractions
    Estimate blur_m;                  ///< standard deviation of the point spread function with the voxel
    struct OfShape {
        Estimate radius_change_m;     ///< added to all radii
        Estimate length_factor{1.0};  ///< of the axes
    };
    std::vector<OfShape> shapes;
};

struct FittedGrain {
    std::size_t shape = 0;
    Pose pose;
    bool cut = false;               ///< reaches beyond the first or the last layer
    double residual = 0.0;          ///< root mean square within three deviations of the blur from its surface
    double position_error_m = 0.0;  ///< standard uncertainty, root of the sum over x, y, z
    double end_error_m = 0.0;       ///< of the capsule's end that is known least, by position and rotation
};

/// Three sweeps over the grains, each with its neighbours, and after each the common parameters. Grains that touch add up to at most 1.
/// Uncertainties from the scatter of sums over blocks as large as the thinnest diameter ("sandwich"), so that noise that is alike in
/// neighbouring voxels does not make them too small.
/// Voxels outside the container do not count.
struct Refined {
    std::vector<FittedGrain> grains;
    Common common;
    double residual = 0.0;  ///< root mean square, all grains
};
/// Only the first `moving` grains move; the others are neighbours of theirs. `start`: its blur must be known, the shapes may be missing.
[[nodiscard]] Refined refine(const geometry::GrayImage& image, const vessels::Container& container, const std::vector<ShapePoints>& shapes,
                             std::vector<FittedGrain> grains, Common start, std::size_t moving = std::numeric_limits<std::size_t>::max());

}  // namespace porepack::scans
