// A patch is a triangle moved out, a part of a cylinder about a convex edge, or a part of a sphere about a corner. It belongs to the
// surface where no other triangle of the core is nearer than the rounding. Those that cannot be nearer are left out first: without creases,
// none is left, and the patch is integrated as a whole. Otherwise it is divided into four again and again, along the crease only, until
// the crease is straight within a part: the part ends where the distance, interpolated between its corners, equals the rounding.
#include "shapes/mesh_patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "shapes/quadrature.hpp"

namespace porepack::shapes {
namespace {

using Point2 = Eigen::Vector2d;

// At parameters (u, v): a point of the surface, the normal there, and its area per area of the parameters.
struct Place {
    Vec3 point, normal;
    double area;
};
using Map = std::function<Place(const Point2&)>;
using Triangle = std::array<Point2, 3>;

constexpr int deepest = 10;  // divisions

class Patch {
public:
    Patch(const TriangleCore& core, double rounding, std::vector<std::size_t> others, Map map, const RoundedBody::SurfacePoint& visit)
        : core_(core), rounding_(rounding), others_(std::move(others)), map_(std::move(map)), visit_(visit) {}

    template <unsigned Points>
    void add(const Triangle& whole) const {
        others_.empty() ? integrate<Points>(whole) : divide<Points>(whole, 0);
    }

private:
    // By how much the nearest of the other triangles is farther away than the rounding.
    [[nodiscard]] double clearance(const Vec3& point) const {
        double nearest = 1e300;
        for (const std::size_t t : others_) nearest = std::min(nearest, core_.distance_to(t, point));
        return nearest - rounding_;
    }

    // The triangle, as a square with one side drawn together.
    template <unsigned Points>
    void integrate(const Triangle& part) const {
        const Point2 b = part[1] - part[0], c = part[2] - part[0];
        const double twice_area = std::abs(b.x() * c.y() - b.y() * c.x());
        for_gauss_points<Points>(0.0, 1.0, [&](double u, double weight_u) {
            for_gauss_points<Points>(0.0, 1.0, [&](double v, double weight_v) {
                const Place at = map_(part[0] + u * ((1.0 - v) * b + v * c));
                visit_(at.point, at.normal, at.area * twice_area * u * weight_u * weight_v);
            });
        });
    }

    template <unsigned Points>
    void divide(const Triangle& part, int depth) const {
        std::array<Vec3, 3> corner;
        for (std::size_t i = 0; i < 3; ++i) corner[i] = map_(part[i]).point;
        const Vec3 middle = map_((part[0] + part[1] + part[2]) / 3.0).point;
        double reach = 0.0;
        for (const Vec3& x : corner) reach = std::max(reach, (x - middle).norm());
        // A part of a sphere or a cylinder with angles up to a right one reaches no farther than 1.2 times its corners.
        const double clear = clearance(middle);
        if (clear > 1.2 * reach) return depth < 2 ? integrate<Points>(part) : depth < 4 ? integrate<6>(part) : integrate<2>(part);
        if (clear < -1.2 * reach) return;
        std::array<double, 3> clearances = {};
        for (std::size_t i = 0; i < 3; ++i) clearances[i] = clearance(corner[i]);
        if (depth >= deepest || (depth > 2 && is_straight(part, clear, clearances, depth))) return keep_clear(part, clearances);
        const Point2 ab = 0.5 * (part[0] + part[1]), bc = 0.5 * (part[1] + part[2]), ca = 0.5 * (part[2] + part[0]);
        for (const Triangle& smaller :
             {Triangle{part[0], ab, ca}, Triangle{ab, part[1], bc}, Triangle{ca, bc, part[2]}, Triangle{ab, bc, ca}})
            divide<Points>(smaller, depth + 1);
    }

    // In the middle, and in those of the sides, the clearance is what the corners say; or it is nowhere negative, as where another triangle
    // begins at the end of the patch.
    [[nodiscard]] bool is_straight(const Triangle& part, double clear, const std::array<double, 3>& clearances, int depth) const {
        const auto [least, most] = std::minmax_element(clearances.begin(), clearances.end());
        double bend = std::abs(clear - (clearances[0] + clearances[1] + clearances[2]) / 3.0), lowest = std::min(clear, *least);
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            const double between = clearance(map_(0.5 * (part[i] + part[j])).point);
            bend = std::max(bend, std::abs(between - 0.5 * (clearances[i] + clearances[j])));
            lowest = std::min(lowest, between);
        }
        return bend < 1e-3 * (*most - *least) || (depth > 5 && lowest > -1e-9 * rounding_);
    }

    // The part of a triangle with a clearance above 0: a polygon.
    void keep_clear(const Triangle& part, const std::array<double, 3>& clearance) const {
        std::array<Point2, 4> kept;
        std::size_t count = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            if (clearance[i] >= 0.0) kept[count++] = part[i];
            if ((clearance[i] >= 0.0) != (clearance[j] >= 0.0))
                kept[count++] = part[i] + clearance[i] / (clearance[i] - clearance[j]) * (part[j] - part[i]);
        }
        for (std::size_t i = 2; i < count; ++i) integrate<2>({kept[0], kept[i - 1], kept[i]});
    }

    const TriangleCore& core_;
    double rounding_;
    std::vector<std::size_t> others_;
    Map map_;
    const RoundedBody::SurfacePoint& visit_;
};

class Surface {
public:
    Surface(const TriangleCore& core, double rounding, const RoundedBody::SurfacePoint& visit)
        : core_(core), rounding_(rounding), visit_(visit) {}

    void visit_all() const {
        for (std::size_t t = 0; t < core_.triangles().size(); ++t) on_triangle(t);
        if (rounding_ == 0.0) return;
        for (const TriangleCore::Edge& edge : core_.edges())
            if (edge.convex) on_edge(edge);
        for (std::size_t c = 0; c < core_.corners().size(); ++c)
            if (!core_.cones()[c].empty()) on_corner(c);
    }

private:
    [[nodiscard]] const Vec3& at(int i) const { return core_.corners()[static_cast<std::size_t>(i)]; }

    // Triangles that may be nearer than the rounding to a point x + rounding u, with x between `ends` and u between `directions`: not those
    // beyond the planes through x normal to u.
    [[nodiscard]] std::vector<std::size_t> others(const std::vector<Vec3>& ends, const std::vector<Vec3>& directions) const {
        std::vector<std::size_t> near;
        if (rounding_ == 0.0) return near;
        Bounds bounds;
        for (const Vec3& x : ends) bounds.add(x, 2.0 * rounding_);
        for (std::size_t t = 0; t < core_.triangles().size(); ++t) {
            Bounds own;
            bool beyond = true;
            for (const int i : core_.triangles()[t]) {
                own.add(at(i), 0.0);
                for (const Vec3& u : directions)
                    for (const Vec3& x : ends) beyond = beyond && u.dot(at(i) - x) <= 1e-10 * rounding_;
            }
            const bool apart = (own.low.array() > bounds.high.array()).any() || (own.high.array() < bounds.low.array()).any();
            if (!beyond && !apart) near.push_back(t);
        }
        return near;
    }

    void on_triangle(std::size_t t) const {
        const auto& corner = core_.triangles()[t];
        const Vec3 &a = at(corner[0]), &b = at(corner[1]), &c = at(corner[2]), &normal = core_.normal(t);
        std::vector<std::size_t> near = others({a, b, c}, {normal});
        std::erase(near, t);
        const double twice_area = (b - a).cross(c - a).norm();
        const Patch patch(
            core_, rounding_, std::move(near),
            [&](const Point2& p) {
                return Place{a + p.x() * (b - a) + p.y() * (c - a) + rounding_ * normal, normal, twice_area};
            },
            visit_);
        patch.add<4>({Point2(0, 0), Point2(1, 0), Point2(0, 1)});
    }

    void on_edge(const TriangleCore::Edge& edge) const {
        const Vec3 along = at(edge.b) - at(edge.a);
        const Vec3 across = (edge.normal_b - edge.normal_b.dot(edge.normal_a) * edge.normal_a).normalized();
        const double turn = std::atan2(edge.normal_b.dot(across), edge.normal_b.dot(edge.normal_a));
        std::vector<std::size_t> near = others({at(edge.a), at(edge.b)}, {edge.normal_a, edge.normal_b});
        for (const int t : edge.triangles) std::erase(near, static_cast<std::size_t>(t));
        const Patch patch(
            core_, rounding_, std::move(near),
            [&](const Point2& p) {
                const Vec3 normal = std::cos(p.y() * turn) * edge.normal_a + std::sin(p.y() * turn) * across;
                return Place{at(edge.a) + p.x() * along + rounding_ * normal, normal, rounding_ * turn * along.norm()};
            },
            visit_);
        patch.add<16>({Point2(0, 0), Point2(1, 0), Point2(1, 1)});
        patch.add<16>({Point2(0, 0), Point2(1, 1), Point2(0, 1)});
    }

    void on_corner(std::size_t c) const {
        const TriangleCore::Cone& cone = core_.cones()[c];
        const Vec3& x = core_.corners()[c];
        std::vector<std::size_t> near = others({x}, cone);
        std::erase_if(near, [&](std::size_t t) {
            const auto& corner = core_.triangles()[t];
            return std::find(corner.begin(), corner.end(), static_cast<int>(c)) != corner.end();
        });
        Vec3 middle = Vec3::Zero();
        for (const Vec3& u : cone) middle += u;
        middle.normalize();
        for (std::size_t i = 0; i < cone.size(); ++i) {
            const Vec3 &b = cone[i], &d = cone[(i + 1) % cone.size()];
            const Vec3 across = (b - middle).cross(d - middle);  // of the flat triangle below that part; its length is twice the area
            const Patch patch(
                core_, rounding_, near,
                [&](const Point2& p) {
                    const Vec3 flat = middle + p.x() * (b - middle) + p.y() * (d - middle);
                    const double away = flat.norm();
                    return Place{x + rounding_ / away * flat, flat / away,
                                 rounding_ * rounding_ * std::abs(across.dot(flat)) / (away * away * away)};
                },
                visit_);
            patch.add<20>({Point2(0, 0), Point2(1, 0), Point2(0, 1)});
        }
    }

    const TriangleCore& core_;
    double rounding_;
    const RoundedBody::SurfacePoint& visit_;
};

}  // namespace

void for_mesh_surface(const TriangleCore& core, double rounding, const RoundedBody::SurfacePoint& visit) {
    Surface(core, rounding, visit).visit_all();
}

}  // namespace porepack::shapes
