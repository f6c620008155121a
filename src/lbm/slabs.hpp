// Where a grid is cut into slabs of about equal numbers of fluid nodes, one for each part of the computation.
#pragma once

#include <vector>

#include "core/communicator.hpp"
#include "core/error.hpp"
#include "geometry/grid.hpp"

namespace porepack::pore_space {
class PoreSpace;
}

namespace porepack::lbm {

/// A slab has at least so many layers: it exchanges as many with its neighbours when a finer grid starts from this one.
inline constexpr int min_layers = 4;

/// Number of parts into which a grid of so many layers can be cut.
[[nodiscard]] inline long max_parts(int layers) {
    return layers < 2 * min_layers ? 1 : layers / min_layers;
}
[[nodiscard]] core::UserError too_many_parts(long parts, long most);

/// Cuts at the same heights on every grid of a sequence, so that the slabs of a grid lie in those of the next coarser one, but for a layer.
class SlabCuts {
public:
    /// One slab.
    SlabCuts() = default;
    /// The fluid is counted on voxels three times as large as those of `grid`, the coarsest, by all parts together. UserError where the
    /// grid has too few layers for so many parts.
    SlabCuts(const pore_space::PoreSpace& space, const geometry::Grid& grid, const core::Communicator& parts);

    /// The slab of this part, with its halo; the whole grid of one part.
    [[nodiscard]] geometry::Grid slab_of(const geometry::Grid& whole, bool periodic, const core::Communicator& parts) const;

private:
    std::vector<double> heights_ = {0.0, 1.0};  ///< of the cuts, as fractions of the grid's height: parts + 1
};

/// Of a slab, over those of the whole grid.
struct SlabShare {
    double height = 1.0, pores = 1.0;
};
/// Those of SlabCuts for so many parts; the pores are counted by `counted_by` together.
[[nodiscard]] std::vector<SlabShare> slab_shares(const pore_space::PoreSpace& space, const geometry::Grid& grid, int parts,
                                                 const core::Communicator& counted_by = core::no_communicator());

}  // namespace porepack::lbm
