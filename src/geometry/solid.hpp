// Solids, evaluated exactly along vertical lines and short segments: the basis of porosity, voxels, slices and flow.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "geometry/vector.hpp"

namespace porepack::geometry {

/// Evaluates a solid along short segments near one point; each thread has its own object.
class SolidProbe {
public:
    virtual ~SolidProbe() = default;
    /// Prepares for segments that stay within `reach` of `point` along every axis.
    virtual void move_to(const Vec3& point, double reach) = 0;
    /// Fraction of the segment from `from` (outside the solid) to `from + step` at which it enters the solid, if it does.
    [[nodiscard]] virtual std::optional<double> first_hit(const Vec3& from, const Vec3& step) const = 0;
};

/// A solid that can be intersected with vertical lines: grains or a closed triangle surface.
class Solid {
public:
    virtual ~Solid() = default;
    /// The parts of the vertical line at (x, y) inside the solid: sorted, disjoint; `parts` is overwritten.
    virtual void column(double x, double y, std::vector<core::Interval>& parts) const = 0;
    /// Parts of the vertical line at (x, y) with every point outside the solid from which a segment of this `length` can pass through the
    /// solid within its first half and end outside. They may hold other points too; `parts` is overwritten. Default: the whole line.
    virtual void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const;
    /// Volume between two heights, where it is known without lines and lies inside the container as a whole.
    [[nodiscard]] virtual std::optional<double> volume_between(double, double) const { return std::nullopt; }
    /// Lowest and highest point.
    [[nodiscard]] virtual Bounds bounds() const = 0;
    [[nodiscard]] virtual std::unique_ptr<SolidProbe> probe() const = 0;
    [[nodiscard]] bool contains(const Vec3& point) const;
};

/// Sorts and joins overlapping intervals in place.
void unite(std::vector<core::Interval>& parts);
/// Keeps what lies in `others` too; both sorted and disjoint.
void intersect(std::vector<core::Interval>& parts, const std::vector<core::Interval>& others);

}  // namespace porepack::geometry
