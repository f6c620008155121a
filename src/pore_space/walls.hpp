// Where the segments between neighbouring cell centres meet a wall: the container's side or the solid inside the section.
#pragma once

#include <memory>
#include <optional>

#include "packing/grains.hpp"
#include "packing/section.hpp"
#include "pore_space/percolation.hpp"

namespace porepack::pore_space {

/// The walls that bound the flow.
struct FlowWalls {
    const geometry::Solid& solid;
    const vessels::Container& container;
    packing::Section section;  ///< solid beyond its planes is left out
};

/// Exact wall distances for one thread. Beyond an open end of the grid lies its mirror image, walls included.
class WallFinder {
public:
    WallFinder(const FlowWalls& walls, const geometry::Grid& grid, const Drive& drive);

    /// Prepares for the segments from this cell centre.
    void move_to(const shapes::Vec3& centre);
    /// Fraction of the segment to centre + step at which it meets a wall; nothing when it meets none. `step` leads to a neighbour.
    [[nodiscard]] std::optional<double> fraction(const shapes::Vec3& step) const;
    /// The first half of the segment to centre + step, the middle included, meets a wall.
    [[nodiscard]] bool closes_first_half(const shapes::Vec3& step) const;

private:
    [[nodiscard]] std::optional<double> straight(const shapes::Vec3& from, const shapes::Vec3& step) const;

    FlowWalls walls_;
    Drive drive_;
    double reach_, end_low_, end_high_;  // of the grid along the drive's axis
    std::unique_ptr<geometry::SolidProbe> probe_;
    shapes::Vec3 centre_ = shapes::Vec3::Zero();
};

}  // namespace porepack::pore_space
