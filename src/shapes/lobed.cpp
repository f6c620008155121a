// Grains with lobes: the union of one cylinder per lobe and of a prism over their axes, all with the same rounding and height. At the
// height where the rounding has taken back the sides by r - r cos(theta), the cross-section is bounded by one arc per lobe, of the radius
// R = a - r + r cos(theta), between the two creases: up to the angle beta + asin(c sin(beta) / R) on both sides, with c the distance of the
// axes from the middle and beta = pi / lobes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "geometry/solid.hpp"
#include "shapes/loops.hpp"
#include "shapes/quadrature.hpp"
#include "shapes/rounded_body.hpp"

namespace porepack::shapes {
namespace {

constexpr double pi = std::numbers::pi;

class Lobed : public RoundedBody {
public:
    explicit Lobed(const LobedSize& size)
        : size_(size),
          beta_(pi / static_cast<double>(size.lobes)),
          away_(0.5 * (size.diameter_m - size.lobe_diameter_m)),
          lobe_(make_ring({.diameter_m = size.lobe_diameter_m, .height_m = size.height_m, .rounding_m = size.rounding_m})) {
        PolyhedronSize between = prism_size(size.lobes, 2.0 * away_, size.height_m, 0.0);
        between.rounding_m = size.rounding_m;
        const double half = half_height();
        for (Vec3& corner : between.corners_m) corner.z() = std::copysign(half, corner.z());
        between_ = make_polyhedron(between);
        for (long i = 0; i < size.lobes; ++i) {
            const double angle = 2.0 * beta_ * static_cast<double>(i);
            centres_.emplace_back(away_ * std::cos(angle), away_ * std::sin(angle), 0.0);
        }
    }

    [[nodiscard]] Json to_json() const override {
        return {{"kind", "lobed"},
                {"lobes", size_.lobes},
                {"diameter_m", size_.diameter_m},
                {"lobe_diameter_m", size_.lobe_diameter_m},
                {"height_m", size_.height_m},
                {"rounding_m", size_.rounding_m}};
    }

    [[nodiscard]] double distance(const Vec3& point, Vec3* outward) const override {
        double nearest = between_->distance(point, outward);
        Vec3 own;
        for (const Vec3& centre : centres_)
            if (const double away = lobe_->distance(point - centre, outward != nullptr ? &own : nullptr); away < nearest) {
                nearest = away;
                if (outward != nullptr) *outward = own;
            }
        return nearest;
    }

    void line(const Vec3& origin, const Vec3& direction, double grown, std::vector<Interval>& parts) const override {
        thread_local std::vector<Interval> own;
        between_->line(origin, direction, grown, parts);
        for (const Vec3& centre : centres_) {
            lobe_->line(origin - centre, direction, grown, own);
            parts.insert(parts.end(), own.begin(), own.end());
        }
        geometry::unite(parts);
    }

    [[nodiscard]] double support(const Vec3& direction) const override {
        double highest = -1e300;
        for (const Vec3& centre : centres_) highest = std::max(highest, centre.dot(direction));
        return highest + lobe_->support(direction);
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> thinned(double depth) const override {
        LobedSize thinner = size_;
        thinner.lobe_diameter_m -= 2.0 * depth;
        thinner.diameter_m -= 2.0 * depth;
        thinner.height_m -= 2.0 * depth;
        thinner.rounding_m = std::max(0.0, thinner.rounding_m - depth);
        const bool whole = thinner.height_m > 0.0 && 0.5 * thinner.lobe_diameter_m - thinner.rounding_m > away_ * std::sin(beta_);
        return whole ? std::make_shared<const Lobed>(thinner) : nullptr;
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> scaled(double factor) const override {
        return make_lobed(
            {size_.lobes, factor * size_.diameter_m, factor * size_.lobe_diameter_m, factor * size_.height_m, factor * size_.rounding_m});
    }

    void for_surface(const SurfacePoint& visit) const override {
        const double r = size_.rounding_m, radius = 0.5 * size_.lobe_diameter_m, half = half_height();
        // Along one arc of every lobe.
        const auto along_arcs = [&](double arc_radius, const auto& visit_point) {
            const double end = arc_end(arc_radius);
            for_gauss_points<20>(-end, end, [&](double phi, double weight) {
                for (const Vec3& centre : centres_) {
                    const double turned = phi + std::atan2(centre.y(), centre.x());
                    const Vec3 out(std::cos(turned), std::sin(turned), 0.0);
                    visit_point(centre, out, phi, weight);
                }
            });
        };
        for_gauss_points<6>(-half, half, [&](double z, double weight_z) {
            along_arcs(radius, [&](const Vec3& centre, const Vec3& out, double, double weight) {
                visit(centre + radius * out + z * Vec3::UnitZ(), out, radius * weight * weight_z);
            });
        });
        for (const double side : {-1.0, 1.0}) {
            // Where lobes hardly overlap, the angle of the arcs changes fast near the flat end: theta = pi/2 - u^2.
            for_gauss_points<20>(0.0, std::sqrt(0.5 * pi), [&](double u, double weight_u) {
                const double theta = 0.5 * pi - u * u, weight_theta = 2.0 * u * weight_u;
                const double arc_radius = radius - r + r * std::cos(theta);
                along_arcs(arc_radius, [&](const Vec3& centre, const Vec3& out, double, double weight) {
                    const Vec3 normal = std::cos(theta) * out + side * std::sin(theta) * Vec3::UnitZ();
                    visit(centre + (radius - r) * out + side * half * Vec3::UnitZ() + r * normal, normal,
                          arc_radius * weight * r * weight_theta);
                });
            });
            // The flat end: all points between the middle and the arcs.
            const double arc_radius = radius - r;
            along_arcs(arc_radius, [&](const Vec3& centre, const Vec3& out, double phi, double weight) {
                const double swept = arc_radius * (arc_radius + away_ * std::cos(phi));
                for_gauss_points<6>(0.0, 1.0, [&](double share, double weight_share) {
                    visit(share * (centre + arc_radius * out) + side * (half + r) * Vec3::UnitZ(), side * Vec3::UnitZ(),
                          share * swept * weight * weight_share);
                });
            });
        }
    }

    // The cross-section's hull is the polygon of the axes, grown by the arc's radius.
    [[nodiscard]] SurfaceSizes hull() const override {
        const double n = static_cast<double>(size_.lobes), r = size_.rounding_m, radius = 0.5 * size_.lobe_diameter_m;
        const double polygon = 0.5 * n * away_ * away_ * std::sin(2.0 * beta_), around = 2.0 * n * away_ * std::sin(beta_);
        const auto area = [&](double R) { return polygon + around * R + pi * R * R; };
        const auto outline = [&](double R) { return around + 2.0 * pi * R; };
        SurfaceSizes convex{.volume_m3 = 2.0 * half_height() * area(radius),
                            .surface_area_m2 = 2.0 * half_height() * outline(radius) + 2.0 * area(radius - r)};
        for_gauss_points<20>(0.0, 0.5 * pi, [&](double theta, double weight) {
            const double R = radius - r + r * std::cos(theta);
            convex.volume_m3 += 2.0 * area(R) * r * std::cos(theta) * weight;
            convex.surface_area_m2 += 2.0 * outline(R) * r * weight;
        });
        return convex;
    }

    [[nodiscard]] std::vector<Facet> facets(double deviation, double) const override {
        const double r = size_.rounding_m, radius = 0.5 * size_.lobe_diameter_m, half = half_height();
        // The deviations of sides and rims add up.
        const int sides = divided_arc(radius, 2.0 * arc_end(radius - r), 0.5 * deviation).parts;
        std::vector<Loop> loops;
        // Each arc from the crease before it to the one after it, which the next arc adds.
        const auto add_loop = [&](double arc_radius, double z) {
            loops.emplace_back();
            const double end = arc_end(arc_radius), crease = away_ * std::cos(beta_) + arc_radius * std::cos(end - beta_);
            const double to_corner = arc_factor(2.0 * end, sides) * arc_radius;
            for (std::size_t i = 0; i < centres_.size(); ++i) {
                const double middle = 2.0 * beta_ * static_cast<double>(i);
                loops.back().emplace_back(crease * std::cos(middle - beta_), crease * std::sin(middle - beta_), z);
                for (int k = 1; k < sides; ++k) {
                    const double phi = middle - end + 2.0 * end * k / sides;
                    loops.back().push_back(centres_[i] + Vec3(to_corner * std::cos(phi), to_corner * std::sin(phi), z));
                }
            }
        };
        const DividedArc rim = divided_arc(r, 0.5 * pi, 0.5 * deviation);
        const auto add_rim = [&](int k, double side) {
            const double theta = 0.5 * pi * k / rim.parts, out = k == 0 || k == rim.parts ? r : rim.factor * r;
            add_loop(radius - r + out * std::cos(theta), side * (half + out * std::sin(theta)));
        };
        for (int k = rim.parts; k >= 0; --k) add_rim(k, -1.0);
        const int pieces = static_cast<int>(std::ceil(2.0 * half / (3.0 * radius)));
        for (int k = 1; k < pieces; ++k) add_loop(radius, half * (2.0 * k / pieces - 1.0));
        for (int k = 0; k <= rim.parts; ++k) add_rim(k, 1.0);
        return facets_between(loops, false);
    }

    [[nodiscard]] bool convex() const override { return false; }
    [[nodiscard]] std::vector<ContactCurve> contact_curves() const override {
        std::vector<ContactCurve> curves;
        for (const Vec3& centre : centres_)
            for (ContactCurve curve : lobe_->contact_curves()) {
                curve.a += centre;
                if (curve.kind != ContactCurve::Kind::rim) curve.b += centre;
                curves.push_back(curve);
            }
        return curves;
    }

    [[nodiscard]] double rounding() const override { return size_.rounding_m; }
    [[nodiscard]] double thickness() const override { return std::min(size_.lobe_diameter_m, size_.height_m); }
    [[nodiscard]] double reach_from(const Vec3& point) const override {
        double farthest = 0.0;
        for (const Vec3& centre : centres_) farthest = std::max(farthest, lobe_->reach_from(point - centre));
        return farthest;
    }
    [[nodiscard]] double maximum_feret_diameter() const override {
        double apart = 0.0;
        for (const Vec3& centre : centres_) apart = std::max(apart, (centre - centres_.front()).norm());
        const double r = size_.rounding_m;
        return std::hypot(apart + size_.lobe_diameter_m - 2.0 * r, 2.0 * half_height()) + 2.0 * r;
    }

private:
    [[nodiscard]] double half_height() const { return 0.5 * size_.height_m - size_.rounding_m; }
    [[nodiscard]] double arc_end(double arc_radius) const { return beta_ + std::asin(away_ * std::sin(beta_) / arc_radius); }

    LobedSize size_;
    double beta_, away_;
    std::shared_ptr<const RoundedBody> lobe_, between_;
    std::vector<Vec3> centres_;
};

}  // namespace

std::shared_ptr<const RoundedBody> make_lobed(const LobedSize& size) {
    if (size.lobes != 3 && size.lobes != 4) throw UserError(fmt::format("a grain with {} lobes", size.lobes), {.allowed = "3 or 4"});
    if (!(size.height_m > 0.0) || !std::isfinite(size.height_m))
        throw UserError(fmt::format("the height of a grain with lobes is {:g} m", size.height_m), {.allowed = "above 0"});
    if (!(size.rounding_m >= 0.0) || size.rounding_m >= 0.5 * std::min(size.height_m, size.lobe_diameter_m))
        throw UserError(fmt::format("the rounding of a grain with lobes is {:g} m", size.rounding_m),
                        {.allowed = fmt::format("0 to below {:.6g} m, half of its height or lobe",
                                                0.5 * std::min(size.height_m, size.lobe_diameter_m))});
    if (!(size.lobe_diameter_m > 0.0) || !(size.diameter_m > size.lobe_diameter_m))
        throw UserError(fmt::format("lobes of {:g} m in a circle of {:g} m", size.lobe_diameter_m, size.diameter_m),
                        {.allowed = "a lobe_diameter_m above 0 and below diameter_m, the diameter of the circle around all lobes"});
    const double half_side =
        0.5 * (size.diameter_m - size.lobe_diameter_m) * std::sin(pi / static_cast<double>(size.lobes));  // between two lobes' axes
    if (!(0.5 * size.lobe_diameter_m - size.rounding_m > half_side))
        throw UserError(
            fmt::format("lobes of {:g} m, {:g} m apart, with a rounding of {:g} m do not overlap", size.lobe_diameter_m, 2.0 * half_side,
                        size.rounding_m),
            {.allowed = fmt::format("a lobe_diameter_m above {:.6g} m, or a smaller rounding_m", 2.0 * (half_side + size.rounding_m))});
    return std::make_shared<const Lobed>(size);
}

}  // namespace porepack::shapes
