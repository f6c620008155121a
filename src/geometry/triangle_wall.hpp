// The side of a vessel that is given by triangles: the closed surface of its inner space.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/interval.hpp"
#include "geometry/box_tree.hpp"
#include "geometry/vector.hpp"

namespace porepack::inline geometry {

/// A closed surface: corners counter-clockwise, seen from outside.
struct TriangleMesh {
    std::vector<Vec3> points_m;
    std::vector<std::array<int, 3>> triangles;
};

/// The horizontal triangles at its greatest height, which are its opening, and those at z = 0, its floor, are no side: above the opening
/// and below the floor the sides go on upright. A query takes some microseconds, whatever the number of triangles.
class TriangleWall {
public:
    /// Throws UserError unless the surface is closed, with normals outward, has no triangle without area, begins at z = 0 and ends at a
    /// horizontal face; `where` names it. That it does not cross itself is not checked.
    TriangleWall(TriangleMesh mesh, const std::string& where);

    [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
    [[nodiscard]] const Bounds& bounds() const { return bounds_; }
    /// Of the sides, between z = 0 and the opening.
    [[nodiscard]] double side_area() const { return side_area_; }
    [[nodiscard]] double volume_between(double z0, double z1) const;

    /// From the nearest side, negative outside; `inward`: the direction in which it grows (unit vector), if it is not null.
    [[nodiscard]] double distance(const Vec3& point, Vec3* inward = nullptr) const;
    /// Numbers of the sides within `reach` of a point, ascending; `found` is overwritten.
    void sides_near(const Vec3& point, double reach, std::vector<std::uint32_t>& found) const;
    /// distance() of a point all of whose sides within its distance are among these.
    [[nodiscard]] double distance(const Vec3& point, const std::vector<std::uint32_t>& sides, Vec3* inward) const;
    /// Smallest distance along a segment.
    [[nodiscard]] double least_distance(const Vec3& a, const Vec3& b) const;
    /// Fraction of the segment from `from` (inside) to `from + step` at which it leaves the inner space through a side, if it does.
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const;
    /// The parts of the vertical line at (x, y) between the sides: sorted, disjoint; `parts` is overwritten.
    void column(double x, double y, std::vector<core::Interval>& parts) const;

    /// A side's edge that sticks into the inner space.
    struct Rim {
        Vec3 a, b;
    };
    /// The part of them that lies within `reach` of a point: visit(number, from, to) with lengths from the rim's end a.
    template <typename Visit>
    void for_rims_near(const Vec3& point, double reach, const Visit& visit) const {
        rim_tree_.search([&](const Bounds& box) { return square_from(box, point); }, [&] { return reach * reach; },
                         [&](std::size_t n) {
                             const Vec3 along = rims_[n].b - rims_[n].a;
                             const double length = along.norm(), at = (point - rims_[n].a).dot(along) / length,
                                          square = reach * reach - (point - rims_[n].a - at / length * along).squaredNorm();
                             if (!(square > 0.0)) return;
                             const double half = std::sqrt(square), from = std::max(0.0, at - half), to = std::min(length, at + half);
                             if (from < to) visit(n, from, to);
                         });
    }
    [[nodiscard]] const Rim& rim(std::size_t number) const { return rims_[number]; }

    /// The sides, as far as they lie between two heights below the floor and above the opening.
    [[nodiscard]] TriangleMesh sides(double z0, double z1) const;

private:
    using Triangle = std::array<int, 3>;
    [[nodiscard]] const Vec3& corner(const Triangle& triangle, std::size_t i) const {
        return points_[static_cast<std::size_t>(triangle[i])];
    }
    struct Nearest;
    void try_side(std::size_t side, const Vec3& point, Nearest& nearest) const;
    [[nodiscard]] double signed_distance(const Nearest& nearest, Vec3* inward) const;
    void find_ends(const std::string& where);
    void lengthen(const std::vector<std::size_t>& end, double z);
    void find_normals();

    TriangleMesh mesh_;
    Bounds bounds_;
    double side_area_ = 0.0;
    std::vector<std::size_t> floor_, opening_;  // triangles of the mesh
    // The sides, then the two ends, moved far away, of which the sides go on.
    std::vector<Vec3> points_;
    std::vector<Triangle> sides_, ends_;
    std::vector<Vec3> normals_, corner_normals_;     // of a side, and around a corner, by angle
    std::vector<std::array<Vec3, 3>> edge_normals_;  // of a side's edge from corner i to the next: sum of the two normals
    std::vector<Rim> rims_;
    BoxTree side_tree_, end_tree_, rim_tree_;
};

}  // namespace porepack::inline geometry
