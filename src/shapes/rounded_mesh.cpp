// Grains of triangles with rounded edges that need not be convex: a core, and a ball swept over its surface. Near an edge whose solid angle
// is more than 180 degrees, the faces moved out by the rounding meet in a crease.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/json.hpp"
#include "geometry/solid.hpp"
#include "shapes/capsule.hpp"
#include "shapes/mesh_patches.hpp"
#include "shapes/rounded_mesh.hpp"
#include "shapes/shape.hpp"

namespace porepack::shapes {
namespace {

class RoundedMesh : public RoundedBody {
public:
    RoundedMesh(std::shared_ptr<const TriangleCore> core, double rounding) : core_(std::move(core)), rounding_(rounding) {
        const auto& corners = core_->corners();
        for (const auto& triangle : core_->triangles()) {
            const std::array<Vec3, 3> x = {corners[static_cast<std::size_t>(triangle[0])], corners[static_cast<std::size_t>(triangle[1])],
                                           corners[static_cast<std::size_t>(triangle[2])]};
            const Vec3& normal = core_->normal(prisms_.size());
            Prism prism{.normal = normal, .height = normal.dot(x[0]), .middle = (x[0] + x[1] + x[2]) / 3.0};
            for (std::size_t i = 0; i < 3; ++i) {
                prism.outwards[i] = (x[(i + 1) % 3] - x[i]).cross(normal);
                prism.sides[i] = prism.outwards[i].dot(x[i]);
                prism.radius = std::max(prism.radius, (x[i] - prism.middle).norm());
            }
            prisms_.push_back(prism);
        }
    }

    [[nodiscard]] Json to_json() const override {
        Json json = {{"kind", "polyhedron"}, {"corners_m", Json::array()}, {"faces", Json::array()}, {"rounding_m", rounding_}};
        for (const Vec3& x : core_->corners()) json["corners_m"].push_back({x.x(), x.y(), x.z()});
        for (const auto& triangle : core_->triangles()) json["faces"].push_back(triangle);
        return json;
    }

    [[nodiscard]] double distance(const Vec3& point, Vec3* outward) const override { return core_->distance(point, outward) - rounding_; }

    // What is within the rounding of the core's surface is in one of the prisms on its triangles, or a capsule about one of its edges.
    // Between such parts, the line lies deeper inside, or outside.
    void line(const Vec3& origin, const Vec3& direction, double grown, std::vector<Interval>& parts) const override {
        parts.clear();
        const double r = std::max(rounding_ + grown, 1e-9 * (core_->bounds().high - core_->bounds().low).norm());
        const auto near = [&](const Vec3& middle, double reach) {
            const Vec3 away = middle - origin;
            return (away - away.dot(direction) * direction).squaredNorm() < reach * reach;
        };
        for (const Prism& prism : prisms_) {
            if (!near(prism.middle, prism.radius + r)) continue;
            Interval part{-1e300, 1e300};
            clip(part, prism.normal, prism.height + r, origin, direction);
            clip(part, -prism.normal, r - prism.height, origin, direction);
            for (std::size_t i = 0; i < 3 && part.low < part.high; ++i) clip(part, prism.outwards[i], prism.sides[i], origin, direction);
            if (part.low < part.high) parts.push_back(part);
        }
        const auto& corners = core_->corners();
        for (const TriangleCore::Edge& edge : core_->edges()) {
            const Vec3 &a = corners[static_cast<std::size_t>(edge.a)], &b = corners[static_cast<std::size_t>(edge.b)];
            if (!near(0.5 * (a + b), 0.5 * (b - a).norm() + r)) continue;
            if (const auto part = line_interval(Capsule{a, b, r}, origin, direction)) parts.push_back(*part);
        }
        geometry::unite(parts);
        std::size_t last = 0;
        for (std::size_t p = 1; p < parts.size(); ++p) {
            const Vec3 between = origin + 0.5 * (parts[last].high + parts[p].low) * direction;
            if (core_->distance(between, nullptr) < r * (1.0 + 1e-9))
                parts[last].high = parts[p].high;
            else
                parts[++last] = parts[p];
        }
        if (!parts.empty()) parts.resize(last + 1);
    }

    [[nodiscard]] double support(const Vec3& direction) const override {
        double highest = -1e300;
        for (const Vec3& corner : core_->corners()) highest = std::max(highest, corner.dot(direction));
        return highest + rounding_;
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> thinned(double depth) const override {
        return depth <= rounding_ ? std::make_shared<const RoundedMesh>(core_, rounding_ - depth) : nullptr;
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> scaled(double factor) const override {
        std::vector<Vec3> corners = core_->corners();
        for (Vec3& corner : corners) corner *= factor;
        return std::make_shared<const RoundedMesh>(std::make_shared<const TriangleCore>(std::move(corners), core_->triangles()),
                                                   factor * rounding_);
    }

    void for_surface(const SurfacePoint& visit) const override { for_mesh_surface(*core_, rounding_, visit); }

    [[nodiscard]] double surface_error() const override { return rounding_ > 0.0 ? 1e-6 : 1e-9; }

    [[nodiscard]] SurfaceSizes hull() const override {
        Shape balls;
        for (const Vec3& corner : core_->corners())
            balls.capsules.push_back({corner, corner, std::max(rounding_, 1e-9 * reach_from(corner))});
        return shapes::hull(balls);
    }
    [[nodiscard]] std::vector<Facet> facets(double, double) const override { return {}; }

    [[nodiscard]] bool convex() const override { return false; }
    [[nodiscard]] std::vector<ContactCurve> contact_curves() const override {
        std::vector<ContactCurve> curves;
        const auto& corners = core_->corners();
        for (std::size_t c = 0; c < corners.size(); ++c)
            if (!core_->cones()[c].empty()) curves.push_back({.kind = ContactCurve::Kind::corner, .a = corners[c], .radius = rounding_});
        for (const TriangleCore::Edge& edge : core_->edges())
            if (edge.convex)
                curves.push_back({.kind = ContactCurve::Kind::edge,
                                  .a = corners[static_cast<std::size_t>(edge.a)],
                                  .b = corners[static_cast<std::size_t>(edge.b)],
                                  .radius = rounding_});
        return curves;
    }

    [[nodiscard]] double rounding() const override { return rounding_; }
    [[nodiscard]] double thickness() const override { return 2.0 * (rounding_ + core_->neck_radius()); }
    [[nodiscard]] double reach_from(const Vec3& point) const override {
        double farthest = 0.0;
        for (const Vec3& corner : core_->corners()) farthest = std::max(farthest, (corner - point).norm());
        return farthest + rounding_;
    }
    [[nodiscard]] double maximum_feret_diameter() const override {
        double farthest = 0.0;
        for (const Vec3& corner : core_->corners()) farthest = std::max(farthest, reach_from(corner));
        return farthest + rounding_;
    }

private:
    // A triangle moved out and in by the rounding.
    struct Prism {
        Vec3 normal;
        double height;  // of its plane
        Vec3 middle;
        double radius = 0.0;  // about the middle
        std::array<Vec3, 3> outwards = {};
        std::array<double, 3> sides = {};
    };

    static void clip(Interval& part, const Vec3& normal, double height, const Vec3& origin, const Vec3& direction) {
        const double rise = normal.dot(direction), below = height - normal.dot(origin);
        if (std::abs(rise) < 1e-14 * normal.norm()) {
            if (below <= 0.0) part = {1.0, -1.0};
        } else if (rise > 0.0) {
            part.high = std::min(part.high, below / rise);
        } else {
            part.low = std::max(part.low, below / rise);
        }
    }

    std::shared_ptr<const TriangleCore> core_;
    double rounding_;
    std::vector<Prism> prisms_;
};

}  // namespace

std::shared_ptr<const RoundedBody> make_rounded_mesh(std::shared_ptr<const TriangleCore> core, double rounding_m) {
    return std::make_shared<const RoundedMesh>(std::move(core), rounding_m);
}

}  // namespace porepack::shapes
