// Distances to the surface of the solid in an image, and a grain moved onto that surface.
#pragma once

#include <vector>

#include "geometry/gray_image.hpp"
#include "scans/shape_points.hpp"

namespace porepack::scans {

/// Distance to the surface of the solid at the voxels' centres: negative in the solid. From voxels above the image's level.
struct DistanceMap {
    geometry::Grid grid;
    std::vector<float> distance_m;
    /// Interpolated; beyond the outermost centres the values stay.
    [[nodiscard]] double at(const shapes::Vec3& point) const;
};
[[nodiscard]] DistanceMap distance_map(const geometry::GrayImage& image);

/// Moves a grain so that its surface lies on that of the solid. Returns the mean of the squared distances; far points count less.
double fit_to_surface(const DistanceMap& map, const ShapePoints& shape, Pose& pose);

}  // namespace porepack::scans
