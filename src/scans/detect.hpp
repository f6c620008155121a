// Grains of known shape found in a distance map, one after another; what is found is masked.
#pragma once

#include <vector>

#include "scans/distance_map.hpp"
#include "scans/shape_points.hpp"

namespace porepack::scans {

struct Found {
    std::size_t shape = 0;
    Pose pose;
    double solid_inside = 0.0;  ///< share of the grain's inside, as far as the image shows it, that is solid
    double on_surface = 0.0;    ///< share of its surface that lies on the surface of the solid
    bool cut = false;           ///< reaches beyond the first or the last layer
};

/// Deep voxels of the solid are tried as anchors of the grain in all rotations, scored along the axes (docs/images.md). The best are
/// moved onto the surface by least squares, from several rotations, and kept if they fit and overlap no other grain. Three passes with
/// falling demands, then one for grains that the ends of the image cut. Larger shapes first. Changes the map: grains that were found become
/// pores.
[[nodiscard]] std::vector<Found> detect(DistanceMap& map, const std::vector<ShapePoints>& shapes);

}  // namespace porepack::scans
