// Vessels: what holds a packing, evaluated exactly along lines and segments, as solids are (solid.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/interval.hpp"
#include "core/json_fwd.hpp"
#include "geometry/vector.hpp"

namespace porepack::inline geometry {

class TriangleWall;  // geometry/triangle_wall.hpp

/// Walls for engines that pour: a point is inside if it is inside all of them.
struct VesselWalls {
    struct Plane {
        Vec3 normal;  ///< unit vector into the vessel
        double offset_m;
        /// Distance from the wall, positive inside.
        [[nodiscard]] double distance(const Vec3& point) const { return normal.dot(point) - offset_m; }
    };
    /// About the axis x = y = 0: a tube, or a cone.
    struct Round {
        double radius_m;      ///< at z = 0
        double slope = 0.0;   ///< growth of the radius with the height
        bool inside = false;  ///< grains lie around it, not in it; its slope is 0
        /// Distance from the wall, positive inside the vessel.
        [[nodiscard]] double distance(const Vec3& point) const { return -overlap(point, 0.0); }
        /// Of a ball with the wall.
        [[nodiscard]] double overlap(const Vec3& centre, double radius) const;
        /// Unit vector into the vessel.
        [[nodiscard]] Vec3 normal(const Vec3& point) const;
    };
    std::vector<Plane> planes;
    std::vector<Round> round;
    std::shared_ptr<const TriangleWall> mesh = nullptr;

    /// No segment between two points inside meets them.
    [[nodiscard]] bool convex() const;
};

/// The inner space of a vessel. Its floor and its top are horizontal, where its bounds end; its sides go on beyond both, so that free water
/// may lie there. A side through which the vessel repeats itself is no wall; the period is the size of the bounds. What a vessel does not
/// offer (the functions with a default) is refused where it is asked for, by a message. The floor lies at z = 0; periodic sides, and all
/// sides of a vessel that fills its bounds, begin at 0. Voxels, porosity, flow and diffusion take any vessel; scans, chords and the paper's
/// dots need outlines, pours and OpenFOAM walls().
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
    /// Smallest distance along a segment. Default: at one of its ends, as between convex walls.
    [[nodiscard]] virtual double least_distance(const Vec3& a, const Vec3& b) const { return std::min(distance(a), distance(b)); }
    /// Mean over the heights of an interval, m2: its volume over its length.
    [[nodiscard]] virtual double mean_area(const core::Interval& heights) const = 0;
    /// Area of the sides over the volume between them, 1/m.
    [[nodiscard]] virtual double side_per_volume() const = 0;

    /// The inner space is its bounds: cells of a grid can end at its sides.
    [[nodiscard]] virtual bool fills_bounds() const { return false; }
    /// Inner diameter, if the vessel is a round tube about the axis x = y = 0.
    [[nodiscard]] virtual std::optional<double> tube_diameter() const { return std::nullopt; }
    /// For the engines that pour, and for OpenFOAM; none: refused there.
    [[nodiscard]] virtual std::optional<VesselWalls> walls() const { return std::nullopt; }
    /// The cross-section, if it is the same at all heights: closed lines of corners, the outer one counter-clockwise, holes clockwise. A
    /// circle is a polygon of the same area that is nowhere farther than `deviation_m` from it. Empty: not offered.
    [[nodiscard]] virtual std::vector<std::vector<std::array<double, 2>>> outlines(double /*deviation_m*/) const { return {}; }
    /// The same vessel with bounds of another size; null where it cannot have them.
    [[nodiscard]] virtual std::shared_ptr<const Vessel> resized(const Vec3& /*size_m*/) const { return nullptr; }
};

}  // namespace porepack::inline geometry
