// The grains of a pour as they are created: the same for both engines.
#pragma once

#include "packing/config.hpp"
#include "packing/packing.hpp"
#include "shapes/config.hpp"

namespace porepack::packing {

/// A grain about to be created: origin and orientation of its shape's frame, velocity.
struct Newcomer {
    std::size_t shape;
    shapes::Vec3 position_m;
    shapes::Quaternion orientation;
    shapes::Vec3 velocity_m_per_s;
};
using Batch = std::vector<Newcomer>;

struct Pour {
    std::vector<Batch> batches;
    long thinned = 0;    ///< batches of which fewer grains than asked for had room
    double top_m = 0.0;  ///< no grain is created above it
};
/// All batches of a pour of at most `grains` grains: random poses in a slab one span high at the drop height, clear of the walls and of
/// each other; of each batch as many as fit. Or, with fill = "lattice", one batch on a loose lattice above the floor. Depends on the seed
/// alone. Throws UserError when not one fits.
[[nodiscard]] Pour make_batches(const std::vector<shapes::ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                                double drop_height_m, long grains);

/// Smallest capsule diameter and largest span of all shapes.
[[nodiscard]] double finest_diameter(const std::vector<shapes::ShapeShare>& shapes);
[[nodiscard]] double largest_span(const std::vector<shapes::ShapeShare>& shapes);

}  // namespace porepack::packing
