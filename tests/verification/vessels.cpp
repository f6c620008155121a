// Vessels that are no prisms, or whose cross-section has two pieces: porosity, flow and diffusion in them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <tuple>
#include <vector>

#include "core/json.hpp"
#include "lbm/permeability.hpp"
#include "packing/grains.hpp"
#include "packing/porosity.hpp"
#include "support/helpers.hpp"
#include "tortuosity/tortuosity.hpp"
#include "vessels/config.hpp"

namespace porepack::test {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

// Two square ducts of side 1 side by side, periodic along them.
class TwoDucts : public geometry::Vessel {
public:
    explicit TwoDucts(double between) : between_(between) {}
    [[nodiscard]] Json to_json() const override { return {{"kind", "two ducts"}}; }
    [[nodiscard]] Bounds bounds() const override { return {Vec3::Zero(), Vec3(2.0 + between_, 1.0, 0.25)}; }
    [[nodiscard]] std::array<bool, 3> periodic() const override { return {false, false, true}; }
    void column(double x, double y, std::vector<Interval>& parts) const override {
        parts.clear();
        if (distance({x, y, 0.0}) >= 0.0) parts = {{-endless, endless}};
    }
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        const double start = from.x() > 1.0 + 0.5 * between_ ? 1.0 + between_ : 0.0;
        double first = 2.0;
        for (const auto& [at, way, low] : {std::tuple(from.x(), step.x(), start), std::tuple(from.y(), step.y(), 0.0)})
            if (way != 0.0) first = std::min(first, std::max(0.0, (low + (way > 0.0 ? 1.0 : 0.0) - at) / way));
        return first <= 1.0 ? std::optional(first) : std::nullopt;
    }
    [[nodiscard]] double distance(const Vec3& p) const override {
        const double x = p.x() > 1.0 + 0.5 * between_ ? p.x() - 1.0 - between_ : p.x();
        return std::min({x, 1.0 - x, p.y(), 1.0 - p.y()});
    }
    [[nodiscard]] double mean_area(const Interval&) const override { return 2.0; }
    [[nodiscard]] double side_per_volume() const override { return 4.0; }

private:
    double between_;
};

packing::Grains sphere(const Container& container, const Vec3& centre, double radius) {
    return packing::Grains(Packing{.container = container,
                                   .shapes = {{.id = "s", .capsules = {{Vec3::Zero(), Vec3::Zero(), radius}}}},
                                   .bodies = {{.position_m = centre}}});
}

TEST(Vessels, PorosityInAFunnel) {
    const Container funnel = parse_container("cone:1,2,2");
    const packing::Grains solid = sphere(funnel, {0.1, 0.0, 1.0}, 0.4);
    const double volume = funnel.vessel().mean_area({0.0, 2.0}) * 2.0, exact = 1.0 - 4.0 / 3.0 * std::numbers::pi * 0.064 / volume;
    for (const long lines : {2000L, 20000L, 200000L}) {
        const Porosity found = porosity(solid, funnel, {0.0, 2.0}, lines);
        EXPECT_NEAR(found.value, exact, 2.0 * found.uncertainty + 1e-6) << lines;
        EXPECT_LT(found.uncertainty, 30.0 / static_cast<double>(lines));  // of second order in the spacing of the lines
    }
    const PoreSpace pores = pore_space_of(std::make_shared<const packing::Grains>(solid), funnel, {0.0, 2.0}, 0.8);
    const PhaseImage image = pores.voxelise_at(0.02);
    double pore = 0.0, outside = 0.0;
    for (const std::uint8_t phase : image.phase) {
        pore += phase == Phase::pore ? 1.0 : 0.0;
        outside += phase == Phase::outside ? 1.0 : 0.0;
    }
    EXPECT_NEAR(pore / (static_cast<double>(image.phase.size()) - outside), exact, 2e-3);  // cells of 1/40 of the grain
}

// A slender funnel is a chain of resistances 1 / area, times 1 + slope^2 / 2 for the flow across (Zwanzig 1992, J. Phys. Chem. 96, 3926);
// at its ends, where the planes are flat, less.
TEST(Vessels, DiffusionThroughAFunnel) {
    const Container funnel = parse_container("cone:2,2.4,4");
    const packing::Grains solid = sphere(funnel, {0.0, 0.0, 2.0}, 1e-6);
    const PoreSpace pores = pore_space_of(std::make_shared<const packing::Grains>(solid), funnel, {0.0, 4.0}, 1.0);
    const double slender = (1.0 + 1.2 + 1.44) / (3.0 * 1.2) * (1.0 + 0.5 * 0.05 * 0.05);
    // 2e-4: its ends and higher powers of the slope; the rest is of second order.
    for (const double voxel : {0.2, 0.1, 0.05})
        EXPECT_NEAR(tortuosity::diffusive_on_grid(pores, voxel, Axis::z).value, slender, 2e-4 + 0.05 * voxel * voxel) << voxel;
}

// The wall between the ducts is thinner than a voxel: no link may pass through it.
TEST(Vessels, TwoDuctsCarryWhatTheyCarryAlone) {
    constexpr double square_duct = 0.0351443;  // k of side 1
    for (const double between : {0.02, 0.3}) {
        const Container ducts(std::make_shared<TwoDucts>(between));
        const packing::Grains solid = sphere(ducts, {0.5, 0.5, 0.1}, 1e-6);
        const PoreSpace pores = pore_space_of(std::make_shared<const packing::Grains>(solid), ducts, {0.0, 0.25}, 1.0);
        std::vector<double> errors;
        for (const int voxels : {8, 16, 32}) {
            const double k = lbm::lbm_permeability(pores, 1.0 / voxels, {.iteration_tolerance = 1e-6, .grids = 1}).fine().permeability_m2;
            const double error = std::abs(k / square_duct - 1.0);
            EXPECT_LT(error, 2.0 / (voxels * voxels)) << between << ' ' << voxels;
            errors.push_back(error);
        }
        std::printf("  errors %.3f %.3f %.3f %%\n", 100.0 * errors[0], 100.0 * errors[1], 100.0 * errors[2]);
        EXPECT_LT(errors[2], 2e-3);
        EXPECT_GT(0.5 * std::log2(errors[0] / errors[2]), 1.7);  // 2.2 and 1.8: the walls lie differently in the grids
    }
}

}  // namespace
}  // namespace porepack::test
