// Where the ways between neighbouring cell centres meet a wall: the container's side or the solid inside the section.
#pragma once

#include <memory>
#include <optional>

#include "converters/percolation.hpp"
#include "packing/grains.hpp"

namespace porepack {

/// What flow is bounded by.
struct FlowWalls {
    const Solid& solid;
    const Container& container;
    Section section;  ///< solid beyond its planes is left out
};

/// Exact distances for one thread. Beyond an open end of the grid lies its mirror image, walls included.
class WallFinder {
public:
    WallFinder(const FlowWalls& walls, const Grid& grid, const Drive& drive);

    /// Prepares for the ways from this cell centre.
    void move_to(const Vec3& centre);
    /// Fraction of the way to centre + step at which it meets a wall; nothing when it meets none. `step` reaches a neighbour.
    [[nodiscard]] std::optional<double> fraction(const Vec3& step) const;

private:
    [[nodiscard]] std::optional<double> straight(const Vec3& from, const Vec3& step) const;

    FlowWalls walls_;
    Drive drive_;
    double reach_, end_low_, end_high_;  // of the grid along the drive's axis
    std::unique_ptr<SolidProbe> probe_;
    Vec3 centre_ = Vec3::Zero();
};

}  // namespace porepack
