// Space stretched along the axes, so that a periodic box becomes whole numbers of cubic voxels.
#pragma once

#include <memory>
#include <vector>

#include "core/interval.hpp"
#include "packing/grains.hpp"
#include "pore_space/stretch.hpp"

namespace porepack::pore_space {

/// The image of `inner`. The map keeps fractions of segments: all answers are those of the inner solid at the points divided by the
/// factors.
class StretchedSolid : public geometry::Solid {
public:
    StretchedSolid(std::shared_ptr<const geometry::Solid> inner, const Stretch& stretch);
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    [[nodiscard]] shapes::Bounds bounds() const override;
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;
    [[nodiscard]] bool has_exact_walls() const override { return inner_->has_exact_walls(); }

private:
    void lift(std::vector<core::Interval>& parts) const;

    std::shared_ptr<const geometry::Solid> inner_;
    shapes::Vec3 stretch_;
};

}  // namespace porepack::pore_space
