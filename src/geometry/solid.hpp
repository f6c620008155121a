// Solids, evaluated exactly along vertical lines and short segments: the basis of porosity, voxels, slices and flow.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "geometry/grid.hpp"
#include "geometry/vector.hpp"

namespace porepack::inline geometry {

struct TriangleSurface;

/// Evaluates a solid along short segments near one point; each thread has its own object.
class SolidProbe {
public:
    virtual ~SolidProbe() = default;
    /// Prepares for segments that stay within `reach` of `point` along every axis.
    virtual void move_to(const Vec3& point, double reach) = 0;
    /// Fraction of the segment from `from` (outside the solid) to `from + step` at which it enters the solid, if it does.
    [[nodiscard]] virtual std::optional<double> first_hit(const Vec3& from, const Vec3& step) const = 0;
};

/// A solid that can be intersected with vertical lines: grains, a closed triangle surface, the level set of an image, or an image's voxels.
/// What a solid does not offer (the functions with a default) is refused, or replaced by its voxels, where it is asked for.
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

    /// The walls are known between the centres of any cells; otherwise they lie half-way between the cells of own_grid().
    [[nodiscard]] virtual bool has_exact_walls() const { return true; }
    /// The only grid on which the solid is known; null: any grid.
    [[nodiscard]] virtual const Grid* own_grid() const { return nullptr; }
    /// Phases on layers of own_grid(), or on a slab of them.
    [[nodiscard]] virtual PhaseImage own_phases(const Grid& /*layers*/) const { return {}; }
    /// This solid for whoever asks only between these heights, where that takes less memory; else null. Heights beyond a side that is
    /// `periodic` along z are those at the other one. What it answers elsewhere has no meaning.
    [[nodiscard]] virtual std::shared_ptr<const Solid> between(const std::vector<core::Interval>& /*heights_m*/, bool /*periodic*/) const {
        return nullptr;
    }
    /// From the surface, at most `cap`; negative inside, where a bound is enough: no point is deeper.
    [[nodiscard]] virtual std::optional<double> distance(const Vec3& /*point*/, double /*cap*/) const { return std::nullopt; }
    /// A solid of which every point lies deeper than `depth` in this one: what blocks the flow there blocks it on voxels of that half
    /// diagonal. Null: not known.
    [[nodiscard]] virtual std::shared_ptr<const Solid> thinned(double /*depth*/) const { return nullptr; }
    /// The closed surface that bounds it, if it is given as one.
    [[nodiscard]] virtual const TriangleSurface* surface() const { return nullptr; }

    [[nodiscard]] bool contains(const Vec3& point) const;
};

/// Sorts and joins overlapping intervals in place.
void unite(std::vector<core::Interval>& parts);
/// z lies in one of them.
[[nodiscard]] bool contains(const std::vector<core::Interval>& parts, double z);
/// One part from minus to plus infinity: all of a line.
[[nodiscard]] bool is_whole_line(const std::vector<core::Interval>& parts);
/// Keeps what lies in `others` too; both sorted and disjoint.
void intersect(std::vector<core::Interval>& parts, const std::vector<core::Interval>& others);

}  // namespace porepack::inline geometry
