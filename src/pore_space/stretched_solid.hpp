// Space stretched along the axes, so that a periodic box becomes whole numbers of cubic voxels.
#pragma once

#include <optional>

#include "core/interval.hpp"
#include "geometry/grid.hpp"
#include "packing/grains.hpp"

namespace porepack::pore_space {

/// Factors of the axes x, y and z.
using Stretch = std::array<double, 3>;
/// That makes the grid's cells cubes of the same volume; none where they are cubes.
[[nodiscard]] std::optional<Stretch> stretch_to_cubes(const geometry::Grid& grid);
void stretch_grid(geometry::Grid& grid, const Stretch& stretch);
/// Largest |factor - 1|.
[[nodiscard]] double strain_of(const std::optional<Stretch>& stretch);

/// The image of `inner`. The map keeps fractions of segments: all answers are those of the inner solid at the points divided by the
/// factors.
class StretchedSolid : public geometry::Solid {
public:
    StretchedSolid(std::shared_ptr<const geometry::Solid> inner, const Stretch& stretch);
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] shapes::Bounds bounds() const override;
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;

private:
    void lift(std::vector<core::Interval>& parts) const;

    std::shared_ptr<const geometry::Solid> inner_;
    shapes::Vec3 stretch_;
};

}  // namespace porepack::pore_space
