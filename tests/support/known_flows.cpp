#include "support/known_flows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pore_space/pore_space.hpp"

namespace porepack::test {
using namespace lbm;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
namespace {

constexpr double pi = std::numbers::pi;

class Duct : public Solid {
public:
    using Depth = std::function<double(double, double)>;
    explicit Duct(Depth depth) : depth_(std::move(depth)) {}
    void column(double x, double y, std::vector<Interval>& parts) const override {
        parts.clear();
        if (depth_(x, y) <= 0.0) parts.push_back({-10.0, 10.0});
    }
    [[nodiscard]] Bounds bounds() const override { return {Vec3::Constant(-10), Vec3::Constant(10)}; }
    [[nodiscard]] std::unique_ptr<SolidProbe> probe() const override {
        struct Bisection : SolidProbe {
            const Depth& depth;
            explicit Bisection(const Depth& d) : depth(d) {}
            void move_to(const Vec3&, double) override {}
            [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
                const auto inside = [&](double at) { return depth(from.x() + at * step.x(), from.y() + at * step.y()) > 0.0; };
                if (inside(1.0)) return std::nullopt;
                double low = 0.0, high = 1.0;
                while (high - low > 1e-14) (inside(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
                return low;
            }
        };
        return std::make_unique<Bisection>(depth_);
    }

private:
    Depth depth_;
};

KnownFlow of_packing(std::string name, Packing packing, double permeability, double diameter) {
    KnownFlow flow;
    flow.name = std::move(name);
    flow.packing = std::move(packing);
    flow.permeability_m2 = permeability;
    flow.diameter_m = diameter;
    flow.container = flow.packing.container;
    flow.solid = std::make_shared<const Grains>(flow.packing);
    return flow;
}

Packing box_of(const std::vector<Capsule>& capsules, const Vec3& size) {
    return {.container = vessels::make_box(size, {true, true, true}), .shapes = {{.id = "grain", .capsules = capsules}}, .bodies = {}};
}

double sphere_radius(double solid_fraction, std::size_t spheres) {
    return std::cbrt(3.0 * solid_fraction / (4.0 * pi * static_cast<double>(spheres)));
}

}  // namespace

std::span<const SphereDrag> sphere_drags() {
    static constexpr SphereDrag rows[] = {{0.01, 1.585651, 1.602758},  {0.027, 2.007748, 2.044056}, {0.064, 2.810198, 2.889385},
                                          {0.125, 4.291589, 4.446384}, {0.3, 12.06434, 12.65732},   {0.343, 15.39949, 16.33505},
                                          {0.4, 21.23809, 23.10930},   {0.5, 37.0108, 44.02567},    {0.6, 0.0, 88.8734},
                                          {pi / 6.0, 42.1005, 0.0},    {0.680175, 0.0, 162.779}};
    return rows;
}

std::span<const CylinderDrag> cylinder_drags() {
    static constexpr CylinderDrag rows[] = {
        {0.1, 24.8317, 12.305}, {0.3, 102.881, 44.5254}, {0.5, 532.548, 141.349}, {0.7, 13519.2, 476.482}};
    return rows;
}

PoreSpace KnownFlow::space() const {
    return pore_space_of(solid, container, {0.0, container.size().z()}, diameter_m);
}

KnownFlow sphere_array(double solid_fraction, double drag, const std::vector<Vec3>& centres, const Vec3& shift) {
    const double r = sphere_radius(solid_fraction, centres.size());
    Packing packing = box_of({{Vec3::Zero(), Vec3::Zero(), r}}, Vec3::Ones());
    for (const Vec3& centre : centres) {
        Vec3 at = centre + shift;
        for (int a = 0; a < 3; ++a) at[a] -= std::floor(at[a]);
        packing.bodies.push_back({.shape = 0, .position_m = at});
    }
    return of_packing(fmt::format("{} spheres {:.3f}", centres.size() == 1 ? "simple cubic" : "body-centred", solid_fraction),
                      std::move(packing), 2.0 * r * r / (9.0 * solid_fraction * drag), 2.0 * r);
}

KnownFlow cylinder_array(double solid_fraction, double drag, double height, const Vec3& shift, Axis direction) {
    const double r = std::sqrt(solid_fraction / pi);
    Packing packing = box_of({{Vec3(0, 0, -2), Vec3(0, 0, 3), r}}, Vec3(1, 1, height));
    packing.bodies.push_back({.shape = 0, .position_m = {0.5 + shift.x(), 0.5 + shift.y(), 0.0}});
    KnownFlow flow = of_packing(fmt::format("square cylinders {:g} along {}", solid_fraction, name_of(direction)), std::move(packing),
                                1.0 / drag, 2.0 * r);
    flow.direction = direction;
    return flow;
}

KnownFlow turned_array(double solid_fraction, double drag) {
    const double r = sphere_radius(solid_fraction, 1);
    Packing packing = box_of({{Vec3::Zero(), Vec3::Zero(), r}}, Vec3(5, 5, 1));
    for (int i = -10; i <= 10; ++i)
        for (int j = -10; j <= 10; ++j) {
            const Vec3 at(0.8 * i - 0.6 * j + 0.13, 0.6 * i + 0.8 * j + 0.29, 0.5);
            if ((at.array() >= 0.0).all() && at.x() < 5.0 && at.y() < 5.0) packing.bodies.push_back({.shape = 0, .position_m = at});
        }
    return of_packing("turned simple cubic", std::move(packing), 2.0 * r * r / (9.0 * solid_fraction * drag), 2.0 * r);
}

KnownFlow three_layers(double solid_fraction, double drag) {
    const double r = sphere_radius(solid_fraction, 1);
    Packing packing = box_of({{Vec3::Zero(), Vec3::Zero(), r}}, Vec3(1, 1, 6));
    packing.container = vessels::make_box(packing.container.size(), {true, true, false});
    for (const double z : {1.5, 2.5, 3.5}) packing.bodies.push_back({.shape = 0, .position_m = {0.5, 0.5, z}});
    return of_packing(fmt::format("three layers of spheres {:.3f}", solid_fraction), std::move(packing),
                      2.0 * r * r / (9.0 * solid_fraction * drag), 2.0 * r);
}

KnownFlow duct(const std::string& name, std::function<double(double, double)> depth, double width, double flow_rate, double height) {
    KnownFlow flow;
    flow.name = name;
    flow.permeability_m2 = flow_rate;
    flow.diameter_m = width;
    flow.container = vessels::make_box({1, 1, height}, {true, true, true});
    flow.solid = std::make_shared<const Duct>(std::move(depth));
    return flow;
}

std::vector<KnownFlow> random_known_flows(unsigned seed, double height) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    const auto place = [&] {
        const double x = unit(), y = unit(), z = unit();
        return Vec3(x, y, z);
    };
    std::vector<KnownFlow> flows;
    for (const SphereDrag& row : sphere_drags()) {
        if (row.simple_cubic > 0.0) flows.push_back(sphere_array(row.solid_fraction, row.simple_cubic, simple_cubic(), place()));
        if (row.body_centred > 0.0) flows.push_back(sphere_array(row.solid_fraction, row.body_centred, body_centred(), place()));
    }
    for (const CylinderDrag& row : cylinder_drags()) {
        flows.push_back(cylinder_array(row.solid_fraction, row.across, height, place(), Axis::x));
        flows.push_back(cylinder_array(row.solid_fraction, row.along, height, place(), Axis::z));
    }
    // A slit repeats after 1/sqrt(p^2 + q^2) across its slope q/p; its flow rate is H^3 / (12 period) per unit of area.
    for (const auto& [p, q] : {std::pair{1, 2}, {1, 3}, {2, 3}}) {
        const double period = 1.0 / std::hypot(p, q), width = (0.4 + 0.3 * unit()) * period, offset = unit() * period;
        const auto depth = [=, p = p, q = q](double x, double y) {
            const double across = (p * x + q * y) * period + offset;
            return 0.5 * width - std::abs(across - period * std::round(across / period));
        };
        flows.push_back(duct(fmt::format("slit {}:{}", p, q), depth, width, width * width / 12.0 * (width / period), height));
    }
    const auto turned = [&](const std::function<double(double, double)>& depth) {
        const double cx = 0.5 + 0.02 * unit(), cy = 0.5 + 0.02 * unit(), angle = pi * unit(), c = std::cos(angle), s = std::sin(angle);
        return [=](double x, double y) { return depth(c * (x - cx) + s * (y - cy), c * (y - cy) - s * (x - cx)); };
    };
    for (const double aspect : {1.0, 0.8, 0.5}) {
        const double a = 0.3 + 0.15 * unit(), b = aspect * a;
        flows.push_back(duct(fmt::format("ellipse 1:{:g}", aspect),
                             turned([=](double x, double y) { return 1.0 - std::hypot(x / a, y / b); }), 2.0 * b,
                             pi * a * b * a * a * b * b / (4.0 * (a * a + b * b)), height));
    }
    const double half = 0.28 + 0.05 * unit();
    flows.push_back(duct("square", turned([=](double x, double y) { return half - std::max(std::abs(x), std::abs(y)); }), 2.0 * half,
                         0.03514425 * std::pow(2.0 * half, 4), height));
    flows.push_back(duct("rectangle 2:1",
                         turned([=](double x, double y) { return std::min(half - std::abs(x), 0.5 * half - std::abs(y)); }), half,
                         0.05717042 * half * half * (2.0 * half * half), height));
    return flows;
}

}  // namespace porepack::test
