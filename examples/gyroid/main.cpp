// A solid of one's own: the gyroid, whose porosity is 1/2 by symmetry. Porosity, k and tortuosity factor on three grids.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <porepack/core/error.hpp>
#include <porepack/geometry/solid.hpp>
#include <porepack/lbm/permeability.hpp>
#include <porepack/tortuosity/tortuosity.hpp>
#include <porepack/vessels/container.hpp>

using namespace porepack;
using geometry::Vec3;

constexpr double wave = 2.0 * std::numbers::pi;  // the cell of the gyroid is 1 m wide

// Solid where sin x cos y + sin y cos z + sin z cos x > 0.
class Gyroid : public geometry::Solid {
public:
    static double value(const Vec3& p) {
        const Vec3 s = (wave * p).array().sin(), c = (wave * p).array().cos();
        return s.x() * c.y() + s.y() * c.z() + s.z() * c.x();
    }
    // On a vertical line the function is a + r cos(wave z - phase): positive in one interval of each period.
    void column(double x, double y, std::vector<core::Interval>& parts) const override {
        const double a = std::sin(wave * x) * std::cos(wave * y), s = std::sin(wave * y), c = std::cos(wave * x), r = std::hypot(s, c);
        parts.clear();
        if (a + r <= 0.0) return;
        if (a >= r) {
            parts.push_back({-1.0, 2.0});
            return;
        }
        const double phase = std::atan2(c, s) / wave, half = std::acos(-a / r) / wave;
        for (int period = -2; period <= 3; ++period) parts.push_back({phase + period - half, phase + period + half});
        geometry::unite(parts);
    }
    geometry::Bounds bounds() const override { return {Vec3::Constant(-1.0), Vec3::Constant(2.0)}; }
    std::unique_ptr<geometry::SolidProbe> probe() const override { return std::make_unique<Probe>(); }

private:
    struct Probe : geometry::SolidProbe {
        void move_to(const Vec3&, double) override {}
        // The first change of sign among four pieces, located by bisection.
        std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
            for (int piece = 1; piece <= 4; ++piece)
                if (value(from + piece / 4.0 * step) > 0.0) {
                    double low = (piece - 1) / 4.0, high = piece / 4.0;
                    for (int halving = 0; halving < 30; ++halving)
                        (value(from + 0.5 * (low + high) * step) > 0.0 ? high : low) = 0.5 * (low + high);
                    return high;
                }
            return std::nullopt;
        }
    };
};

int main() try {
    const vessels::Container cell = vessels::make_box({1.0, 1.0, 1.0}, {true, true, true});
    const auto pores = pore_space::pore_space_of(std::make_shared<Gyroid>(), cell, {0.0, 1.0}, 0.5);
    constexpr std::array voxels = {32, 48, 72};
    std::array<double, 3> k{}, factor{};
    for (int grid = 0; grid < 3; ++grid) {
        const double voxel_size_m = 1.0 / voxels[grid];
        k[grid] = lbm::lbm_permeability(pores, voxel_size_m, {.iteration_tolerance = 1e-6, .grids = 1}).fine().permeability_m2;
        factor[grid] = tortuosity::diffusive_on_grid(pores, voxel_size_m, core::Axis::z).value;
        std::printf("%2d voxels: k = %.7f m2, tortuosity factor %.5f\n", voxels[grid], k[grid], factor[grid]);
    }
    const auto order = [](const auto& v) { return std::log((v[1] - v[0]) / (v[2] - v[1])) / std::log(1.5); };
    std::printf("porosity %.5f, observed orders: k %.2f, tortuosity factor %.2f\n", pores.porosity().value, order(k), order(factor));
    return 0;
} catch (const core::Error& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return 1;
}
