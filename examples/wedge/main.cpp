// A vessel of one's own: a wedge whose cross-section is an equilateral triangle of side 1 m. Empty, it is a duct with k = 1/80 m2.
#include <array>
#include <cmath>
#include <cstdio>

#include <porepack/core/error.hpp>
#include <porepack/core/json.hpp>
#include <porepack/geometry/vessel.hpp>
#include <porepack/lbm/permeability.hpp>
#include <porepack/tortuosity/tortuosity.hpp>

using namespace porepack;
using geometry::Vec3;

constexpr double height_m = 2.0 / 30.0;

class Wedge : public geometry::Vessel {
public:
    core::Json to_json() const override { return {{"kind", "wedge"}, {"height_m", height_m}}; }
    geometry::Bounds bounds() const override { return {Vec3(-0.5, 0.0, 0.0), Vec3(0.5, std::sqrt(0.75), height_m)}; }
    std::array<bool, 3> periodic() const override { return {false, false, true}; }
    void column(double x, double y, std::vector<core::Interval>& parts) const override {
        parts.clear();
        if (distance(Vec3(x, y, 0.0)) >= 0.0) parts.push_back({-HUGE_VAL, HUGE_VAL});
    }
    std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        double first = 2.0;
        for (const auto& plane : walls_.planes)
            if (const double rate = plane.normal.dot(step); rate < 0.0)
                first = std::min(first, std::max(0.0, -plane.distance(from) / rate));
        return first <= 1.0 ? std::optional(first) : std::nullopt;
    }
    double distance(const Vec3& point) const override {
        double nearest = 1e300;
        for (const auto& plane : walls_.planes) nearest = std::min(nearest, plane.distance(point));
        return nearest;
    }
    double mean_area(const core::Interval&) const override { return std::sqrt(3.0) / 4.0; }
    double side_per_volume() const override { return 3.0 / mean_area({}); }
    std::optional<geometry::VesselWalls> walls() const override { return walls_; }

private:
    const double s = std::sqrt(0.75);
    const geometry::VesselWalls walls_{.planes = {{Vec3::UnitY(), 0.0}, {Vec3(s, -0.5, 0.0), -0.5 * s}, {Vec3(-s, -0.5, 0.0), -0.5 * s}},
                                       .round = {}};
};

// Nothing in it.
class Nothing : public geometry::Solid {
public:
    void column(double, double, std::vector<core::Interval>& parts) const override { parts.clear(); }
    void near_column(double, double, double, std::vector<core::Interval>& parts) const override { parts.clear(); }
    geometry::Bounds bounds() const override { return Wedge().bounds(); }
    std::unique_ptr<geometry::SolidProbe> probe() const override { return std::make_unique<Probe>(); }

private:
    struct Probe : geometry::SolidProbe {
        void move_to(const Vec3&, double) override {}
        std::optional<double> first_hit(const Vec3&, const Vec3&) const override { return std::nullopt; }
    };
};

int main() try {
    const vessels::Container wedge(std::make_shared<Wedge>());
    const auto pores = pore_space::pore_space_of(std::make_shared<Nothing>(), wedge, {0.0, height_m}, 1.0);
    // 30 voxels along the side are 26.0 along the height of the triangle: both walls lie alike in all three grids.
    std::array<double, 3> k_error{}, factor_error{};
    for (int grid = 0; grid < 3; ++grid) {
        const double h = 1.0 / (30 << grid);
        k_error[grid] = 80.0 * lbm::lbm_permeability(pores, h, {.iteration_tolerance = 1e-6, .grids = 1}).permeability_m2 - 1.0;
        factor_error[grid] = tortuosity::diffusive_on_grid(pores, h, core::Axis::z).value - 1.0;
        std::printf("%3d voxels: errors of k %+.4f %%, of the tortuosity factor %+.4f %%\n", 30 << grid, 100.0 * k_error[grid],
                    100.0 * factor_error[grid]);
    }
    const double k_order = 0.5 * std::log2(k_error[0] / k_error[2]), factor_order = 0.5 * std::log2(factor_error[0] / factor_error[2]);
    std::printf("porosity %.5f, observed orders: k %.2f, tortuosity factor %.2f\n", pores.porosity().value, k_order, factor_order);
    return 0;
} catch (const core::Error& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return 1;
}
