// The grains of a pour as they are created: the same for both engines.
#pragma once

#include <vector>

#include "packing/packing.hpp"
#include "pouring/config.hpp"
#include "shapes/config.hpp"

namespace porepack::pouring {

/// A grain to be created: origin and orientation of its shape's frame, velocity.
struct Newcomer {
    std::size_t shape;
    shapes::Vec3 position_m;
    shapes::Quaternion orientation;
    shapes::Vec3 velocity_m_per_s;
};
using Batch = std::vector<Newcomer>;

struct Pour {
    std::vector<Batch> batches;
    long thinned = 0;    ///< batches with fewer grains than requested, for lack of space
    double top_m = 0.0;  ///< no grain is created above it
};
/// All batches of a pour of at most `grains` grains: random poses in a slab of one maximum Feret diameter at drop height, no contact with
/// walls or grains; as many per batch as fit. Or, with fill = "lattice", one batch on a lattice above the floor. Depends only on
/// the seed. With fill = "scatter", one batch of grains at rest at random places of the whole box. Throws UserError when no grain fits.
[[nodiscard]] Pour make_batches(const std::vector<shapes::ShapeShare>& shapes, const vessels::Container& container,
                                const PackingConfig& config, double drop_height_m, long grains);

/// Minimum capsule diameter and maximum Feret diameter of all shapes.
[[nodiscard]] double finest_diameter(const std::vector<shapes::ShapeShare>& shapes);
[[nodiscard]] double maximum_feret_diameter(const std::vector<shapes::ShapeShare>& shapes);

}  // namespace porepack::pouring
