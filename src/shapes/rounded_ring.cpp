// Cylinders with flat ends, and rings. The core is a rectangle that is turned about the axis z; the body is the union of the core made
// wider, the core made higher, and one torus around each rim.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/vectorised.hpp"
#include "geometry/solid.hpp"
#include "shapes/loops.hpp"
#include "shapes/planar.hpp"
#include "shapes/quadrature.hpp"
#include "shapes/rounded_body.hpp"
#include "shapes/torus.hpp"

namespace porepack::shapes {
namespace {

constexpr double pi = std::numbers::pi;

struct RingCore {
    double outer, inner;  ///< inner < 0: no hole
    double half_height, rounding;
};

// No jumps, so that several points can be computed at once.
inline void ring_distance(const RingCore& ring, double hole, double x, double y, double z, double& distance, double& outward_x,
                          double& outward_y, double& outward_z) {
    const double rho = std::sqrt(x * x + y * y), beyond = rho - ring.outer, before = hole - rho;
    const double across = beyond < before ? before : beyond, above = std::abs(z) - ring.half_height;
    const double least = across < above ? across : above, most = across < above ? above : across;  // past the rim: least > 0
    const double from_rim = least > 0.0 ? std::sqrt(across * across + above * above) : 1.0;
    const double away = least > 0.0 ? from_rim : most, to_side = across > above ? 1.0 : 0.0;
    const double out = least > 0.0 ? across / from_rim : to_side, up = least > 0.0 ? above / from_rim : 1.0 - to_side;
    const double turn = (beyond < before ? -out : out) / (rho > 0.0 ? rho : 1.0);
    distance = away - ring.rounding;
    outward_x = turn * (rho > 0.0 ? x : 1.0);
    outward_y = turn * y;
    outward_z = std::copysign(up, z);
}

double hole_of(const RingCore& ring) {
    return ring.inner < 0.0 ? -1e300 : ring.inner;
}

POREPACK_VECTORISED void ring_distances(const RingCore& ring, const PointRow& points, DistanceRow& found) {
    const double hole = hole_of(ring);
    const double *const x = points.x.data(), *const y = points.y.data(), *const z = points.z.data();
    double *const distance = found.distance.data(), *const outward_x = found.outward.x.data(), *const outward_y = found.outward.y.data(),
                  *const outward_z = found.outward.z.data();
    const RingCore core = ring;
#pragma GCC ivdep
    for (int i = 0; i < PointRow::most; ++i)
        ring_distance(core, hole, x[i], y[i], z[i], distance[i], outward_x[i], outward_y[i], outward_z[i]);
}

class RoundedRing : public RoundedBody {
public:
    // Of the core; `inner` < 0: no hole.
    RoundedRing(double outer, double inner, double half_height, double rounding)
        : outer_(outer), inner_(inner), half_height_(half_height), rounding_(rounding) {}

    [[nodiscard]] Json to_json() const override {
        Json json = {{"kind", has_hole() ? "ring" : "cylinder"},
                     {"diameter_m", 2.0 * (outer_ + rounding_)},
                     {"height_m", 2.0 * (half_height_ + rounding_)},
                     {"rounding_m", rounding_}};
        if (has_hole()) json["inner_diameter_m"] = 2.0 * (inner_ - rounding_);
        return json;
    }

    [[nodiscard]] double distance(const Vec3& point, Vec3* outward) const override {
        Vec3 to;
        double away = 0.0;
        const RingCore core = this->core();
        ring_distance(core, hole_of(core), point.x(), point.y(), point.z(), away, to.x(), to.y(), to.z());
        if (outward != nullptr) *outward = to;
        return away;
    }

    void distances(const PointRow& points, DistanceRow& found) const override { ring_distances(core(), points, found); }

    void line(const Vec3& origin, const Vec3& direction, double grown, std::vector<Interval>& parts) const override {
        parts.clear();
        const double r = rounding_ + grown;
        const double reach2 = (outer_ + r) * (outer_ + r) + (half_height_ + r) * (half_height_ + r);
        if ((origin - origin.dot(direction) * direction).squaredNorm() >= reach2) return;
        add_between(origin, direction, outer_ + r, inner_ - r, half_height_, parts);
        add_between(origin, direction, outer_, inner_, half_height_ + r, parts);
        for (const double z : {-half_height_, half_height_}) {
            const Vec3 from_rim = origin - z * Vec3::UnitZ();
            add_torus_parts(outer_, r, from_rim, direction, parts);
            if (has_hole()) add_torus_parts(inner_, r, from_rim, direction, parts);
        }
        geometry::unite(parts);
    }

    [[nodiscard]] double support(const Vec3& direction) const override {
        return outer_ * direction.head<2>().norm() + half_height_ * std::abs(direction.z()) + rounding_;
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> thinned(double depth) const override {
        const double r = std::max(0.0, rounding_ - depth), into_core = std::max(0.0, depth - rounding_);
        const double outer = outer_ - into_core, inner = has_hole() ? inner_ + into_core : inner_, half = half_height_ - into_core;
        if (has_hole() && inner <= r) return nullptr;
        if (outer < 0.0 || half < 0.0 || inner > outer || (r == 0.0 && (outer == 0.0 || half == 0.0 || inner == outer))) return nullptr;
        return std::make_shared<const RoundedRing>(outer, inner, half, r);
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> scaled(double factor) const override {
        return std::make_shared<const RoundedRing>(factor * outer_, factor * inner_, factor * half_height_, factor * rounding_);
    }

    void for_surface(const SurfacePoint& visit) const override {
        const double r = rounding_;
        const auto turn = [&](double rho, double z, double n_rho, double n_z, double length) {
            constexpr int angles = 16;
            for (int k = 0; k < angles; ++k) {
                const double phi = 2.0 * pi * k / angles, x = std::cos(phi), y = std::sin(phi);
                visit({rho * x, rho * y, z}, {n_rho * x, n_rho * y, n_z}, 2.0 * pi * rho / angles * length);
            }
        };
        for_gauss_points<6>(-half_height_, half_height_, [&](double z, double weight) {
            turn(outer_ + r, z, 1.0, 0.0, weight);
            if (has_hole()) turn(inner_ - r, z, -1.0, 0.0, weight);
        });
        for (const double side : {-1.0, 1.0}) {
            for_gauss_points<6>(has_hole() ? inner_ : 0.0, outer_,
                                [&](double rho, double weight) { turn(rho, side * (half_height_ + r), 0.0, side, weight); });
            for_gauss_points<20>(0.0, 0.5 * pi, [&](double angle, double weight) {
                const double out = std::cos(angle), up = std::sin(angle);
                turn(outer_ + r * out, side * (half_height_ + r * up), out, side * up, r * weight);
                if (has_hole()) turn(inner_ - r * out, side * (half_height_ + r * up), -out, side * up, r * weight);
            });
        }
    }

    [[nodiscard]] SurfaceSizes hull() const override { return surface_measures(RoundedRing(outer_, -1.0, half_height_, rounding_)); }
    [[nodiscard]] bool convex() const override { return !has_hole(); }
    // The outline of the turned section: around the outer rims from below to above, then around those of the hole.
    [[nodiscard]] std::vector<Facet> facets(double deviation, double turn) const override {
        const double r = rounding_;
        // The deviations of both add up.
        const DividedArc circle = divided_circle(outer_ + r, 0.5 * deviation), rim = divided_arc(r, 0.5 * pi, 0.5 * deviation);
        std::vector<Loop> loops;
        const auto add_loop = [&](double rho, double z) {
            loops.emplace_back();
            for (int i = 0; i < circle.parts; ++i) {
                const double phi = turn + 2.0 * pi * i / circle.parts, to_corner = circle.factor * rho;
                loops.back().emplace_back(to_corner * std::cos(phi), to_corner * std::sin(phi), z);
            }
        };
        // A straight side needs no loops in between, but very long triangles make intersections slow and inaccurate.
        const auto add_side = [&](double rho, double from, double to) {
            const int pieces = static_cast<int>(std::ceil(std::abs(to - from) / (3.0 * (outer_ + r))));
            for (int k = 1; k < pieces; ++k) add_loop(rho, from + (to - from) * k / pieces);
        };
        const auto add_rim = [&](double rho, double z, double start) {
            for (int k = 0; k <= rim.parts; ++k) {
                const double theta = start + 0.5 * pi * k / rim.parts, to_corner = k == 0 || k == rim.parts ? r : rim.factor * r;
                add_loop(rho + to_corner * std::cos(theta), z + to_corner * std::sin(theta));
            }
        };
        add_rim(outer_, -half_height_, -0.5 * pi);
        add_side(outer_ + r, -half_height_, half_height_);
        add_rim(outer_, half_height_, 0.0);
        if (has_hole()) {
            add_rim(inner_, half_height_, 0.5 * pi);
            add_side(inner_ - r, half_height_, -half_height_);
            add_rim(inner_, -half_height_, pi);
        }
        return facets_between(loops, has_hole());
    }

    [[nodiscard]] std::vector<ContactCurve> contact_curves() const override {
        std::vector<ContactCurve> curves;
        const Vec3 top = half_height_ * Vec3::UnitZ();
        for (const Vec3& centre : {Vec3(-top), top}) {
            curves.push_back({.kind = ContactCurve::Kind::rim, .a = centre, .b = Vec3::UnitZ(), .rim_radius = outer_, .radius = rounding_});
            if (has_hole())
                curves.push_back(
                    {.kind = ContactCurve::Kind::rim, .a = centre, .b = Vec3::UnitZ(), .rim_radius = inner_, .radius = rounding_});
        }
        curves.push_back({.kind = ContactCurve::Kind::axis,
                          .a = -top,
                          .b = top,
                          .radius = outer_ + rounding_,
                          .hole_radius = has_hole() ? inner_ - rounding_ : 0.0});
        return curves;
    }

    [[nodiscard]] double rounding() const override { return rounding_; }
    [[nodiscard]] double thickness() const override {
        return 2.0 * (rounding_ + std::min(half_height_, has_hole() ? 0.5 * (outer_ - inner_) : outer_));
    }
    [[nodiscard]] double reach_from(const Vec3& point) const override {
        return std::hypot(point.head<2>().norm() + outer_, std::abs(point.z()) + half_height_) + rounding_;
    }
    [[nodiscard]] double maximum_feret_diameter() const override { return 2.0 * (std::hypot(outer_, half_height_) + rounding_); }

private:
    [[nodiscard]] bool has_hole() const { return inner_ >= 0.0; }
    [[nodiscard]] RingCore core() const { return {outer_, inner_, half_height_, rounding_}; }

    // Between two upright cylinders and the heights -half and half.
    static void add_between(const Vec3& origin, const Vec3& direction, double outer, double inner, double half,
                            std::vector<Interval>& parts) {
        auto whole = within_heights(origin, direction, -half, half);
        const auto disc = whole ? within_circle(origin, direction, outer) : std::nullopt;
        if (!disc) return;
        whole = Interval{std::max(whole->low, disc->low), std::min(whole->high, disc->high)};
        if (whole->low >= whole->high) return;
        const auto hole = inner > 0.0 ? within_circle(origin, direction, inner) : std::nullopt;
        if (!hole || hole->high <= whole->low || hole->low >= whole->high) {
            parts.push_back(*whole);
            return;
        }
        if (hole->low > whole->low) parts.push_back({whole->low, hole->low});
        if (hole->high < whole->high) parts.push_back({hole->high, whole->high});
    }

    double outer_, inner_, half_height_, rounding_;
};

}  // namespace

std::shared_ptr<const RoundedBody> make_ring(const RingSize& size) {
    const bool hole = size.inner_diameter_m > 0.0;
    const char* const name = hole ? "ring" : "cylinder";
    if (!(size.diameter_m > 0.0) || !(size.height_m > 0.0))
        throw UserError(
            fmt::format("a {} needs a diameter and a height above 0, got {:g} m and {:g} m", name, size.diameter_m, size.height_m),
            {.where = "diameter_m, height_m"});
    if (hole && size.inner_diameter_m >= size.diameter_m)
        throw UserError(
            fmt::format("the hole of the ring is as wide as the ring: {:g} m of {:g} m", size.inner_diameter_m, size.diameter_m),
            {.allowed = "an inner_diameter_m below diameter_m"});
    const double wall = 0.5 * (hole ? size.diameter_m - size.inner_diameter_m : size.diameter_m);
    const double largest = 0.5 * std::min(hole ? wall : size.diameter_m, size.height_m);
    constexpr double rounded_off = 1.0 + 1e-12;  // sizes that were written and read back
    if (!(size.rounding_m >= 0.0) || size.rounding_m > rounded_off * largest)
        throw UserError(fmt::format("the rounding of the {} is {:g} m", name, size.rounding_m),
                        {.allowed = fmt::format("0 to {:.6g} m, half of its {}", largest, hole ? "wall or height" : "diameter or height")});
    const double rounding = std::min(size.rounding_m, largest), outer = std::max(0.0, 0.5 * size.diameter_m - rounding);
    return std::make_shared<const RoundedRing>(outer, hole ? std::min(outer, 0.5 * size.inner_diameter_m + rounding) : -1.0,
                                               std::max(0.0, 0.5 * size.height_m - rounding), rounding);
}

}  // namespace porepack::shapes
