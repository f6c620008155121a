// Vessels: what holds a packing, evaluated exactly along lines and segments, as solids are (solid.hpp).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "core/json_fwd.hpp"
#include "geometry/vector.hpp"

namespace porepack::geometry {

/// Walls of a convex vessel, for engines: a point is inside if it is inside all of them.
struct ConvexWalls {
    struct Plane {
        Vec3 normal;  ///< unit vector into the vessel
        double offset_m;
        /// Distance from the wall, positive inside.
        [[nodiscard]] double distance(const Vec3& point) const { return normal.dot(point) - offset_m; }
    };
    std::vector<Plane> planes;
    double tube_radius_m = 0.0;  ///< of a round wall about the axis x = y = 0; 0: none
};

/// The inner space of a vessel. Its floor and its top are horizontal, where its bounds end; its sides go on beyond both, so that free water
/// may lie there. A side through which the vessel repeats itself is no wall; the period is the size of the bounds. What a vessel does not
/// offer (the functions with a default) is refused where it is asked for, by a message. The floor lies at z = 0; periodic sides, and all
/// sides of a vessel that fills its bounds, begin at 0. Voxels, porosity, flow and diffusion take any vessel; scans, chords and the paper's
/// dots need an outline, LIGGGHTS and OpenFOAM a tube or a box.
class Vessel {
public:
    Vessel() = default;
    Vessel(const Vessel&) = delete;
    Vessel& operator=(const Vessel&) = delete;
    virtual ~Vessel() = default;

    /// As in the table [container] of a case and in packing.json: `kind`, and the keys of that kind.
    [[nodiscard]] virtual core::Json to_json() const = 0;
    /// From the floor to the top.
    [[nodiscard]] virtual Bounds bounds() const = 0;
    [[nodiscard]] virtual std::array<bool, 3> periodic() const { return {false, false, false}; }
    /// The parts of the vertical line at (x, y) between the sides: sorted, disjoint; `parts` is overwritten.
    virtual void column(double x, double y, std::vector<core::Interval>& parts) const = 0;
    /// Fraction of the segment from `from` (inside) to `from + step` at which it meets a side, if it does.
    [[nodiscard]] virtual std::optional<double> first_hit(const Vec3& from, const Vec3& step) const = 0;
    /// From the nearest side, exact inside; negative outside, where it may come nearer to zero than the distance is, beside edges.
    [[nodiscard]] virtual double distance(const Vec3& point) const = 0;
    /// Mean over the heights of an interval, m2: its volume over its length.
    [[nodiscard]] virtual double mean_area(const core::Interval& heights) const = 0;
    /// Area of the sides over the volume between them, 1/m.
    [[nodiscard]] virtual double side_per_volume() const = 0;

    /// The inner space is its bounds: cells of a grid can end at its sides.
    [[nodiscard]] virtual bool fills_bounds() const { return false; }
    /// Inner diameter, if the vessel is a round tube about the axis x = y = 0.
    [[nodiscard]] virtual std::optional<double> tube_diameter() const { return std::nullopt; }
    /// For the engines that pour; none: grains are not poured into this vessel.
    [[nodiscard]] virtual std::optional<ConvexWalls> convex_walls() const { return std::nullopt; }
    /// Corners of the cross-section, counter-clockwise, if it is the same at all heights: a circle as a polygon of the same area that is
    /// nowhere farther than `deviation_m` from it. Empty: not offered.
    [[nodiscard]] virtual std::vector<std::array<double, 2>> outline(double /*deviation_m*/) const { return {}; }
    /// The same vessel with bounds of another size; null where it cannot have them.
    [[nodiscard]] virtual std::shared_ptr<const Vessel> resized(const Vec3& /*size_m*/) const { return nullptr; }
};

}  // namespace porepack::geometry
