// A closed surface of triangles that need not be convex: the core of a rounded mesh. What is nearest to a point is searched among the
// triangles listed in the point's cell: a grid over the core and some way around it, each cell with all triangles that can be nearest to
// one of its points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/vector.hpp"

namespace porepack::shapes {

using geometry::Bounds;
using geometry::Vec3;

class TriangleCore {
public:
    /// `triangles`: corners counter-clockwise, seen from outside. Throws UserError unless they bound one volume: closed, with one normal
    /// outward, without a triangle of no area, in one part, and without crossings.
    TriangleCore(std::vector<Vec3> corners, std::vector<std::array<int, 3>> triangles);

    struct Edge {
        int a, b;  ///< corners
        std::array<int, 2> triangles;
        Vec3 normal_a, normal_b;  ///< of these
        bool convex;              ///< the solid's angle is less than 180 degrees, by more than 1e-6
    };
    /// What a corner sees: the directions in which it is the nearest point of the core, a convex polygon on the unit sphere. Empty where
    /// there are none.
    using Cone = std::vector<Vec3>;

    [[nodiscard]] const std::vector<Vec3>& corners() const { return corners_; }
    [[nodiscard]] const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
    [[nodiscard]] const Vec3& normal(std::size_t triangle) const { return planes_[triangle].normal; }
    [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
    [[nodiscard]] const std::vector<Cone>& cones() const { return cones_; }
    [[nodiscard]] const Bounds& bounds() const { return bounds_; }
    [[nodiscard]] double volume() const { return volume_; }

    /// From the surface; negative inside. `outward`: the direction in which it grows (unit vector), and `triangle`: the nearest one, if
    /// they are not null.
    [[nodiscard]] double distance(const Vec3& point, Vec3* outward, std::size_t* triangle = nullptr) const;
    [[nodiscard]] double distance_to(std::size_t triangle, const Vec3& point) const;

    /// The radius of the smallest of the balls that its parts, and the necks between them, hold; to a 32nd of its size.
    [[nodiscard]] double neck_radius() const { return neck_radius_; }

private:
    struct Plane {
        Vec3 normal;
        double height;
    };
    struct Nearest {
        double square = 1e300;
        Vec3 from = Vec3::Zero();      // from there to the point
        const Vec3* normal = nullptr;  // sum of the normals around there, by angle
        std::size_t triangle = 0;
    };
    [[nodiscard]] Nearest nearest(const Vec3& point) const;
    void find_edges();
    void find_cones();
    void require_one_part() const;
    void require_no_crossing() const;
    struct Candidate {
        float from_middle;  // distance from the middle of the cell, not more
        std::uint16_t triangle;
    };
    void list_candidates();
    void add_lists(const Vec3& low, int cells, const std::array<int, 3>& at, const std::vector<std::uint16_t>& from,
                   std::vector<std::vector<Candidate>>& lists) const;
    void find_neck();
    void try_triangle(std::size_t triangle, const Vec3& point, Nearest& nearest) const;

    std::vector<Vec3> corners_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<Plane> planes_;
    std::vector<Edge> edges_;
    std::vector<std::array<int, 3>> edge_of_;  // by triangle: of the side from corner i to the next
    std::vector<Vec3> edge_normals_, corner_normals_;
    std::vector<Cone> cones_;
    Bounds bounds_;
    double extent_ = 0.0, volume_ = 0.0, neck_radius_ = 0.0;

    static constexpr int cells_ = 32;  // along each axis
    Vec3 low_ = Vec3::Zero();
    double cell_ = 0.0;
    // Of each cell, the nearest to its middle first: candidates_[lists_[cell]] to those of the next cell.
    std::vector<std::uint32_t> lists_;
    std::vector<Candidate> candidates_;
};

}  // namespace porepack::shapes
