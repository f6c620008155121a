// Profiles against the radius.
#include <cmath>

#include "lbm/wall_effect.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

// Flow in an annulus between a rod of radius a and the tube, u = R^2 - r^2 + (R^2 - a^2) ln(r/R) / ln(R/a), whose integral over a ring is
// known.
TEST(Wall, ProfileOfAnAnnulus) {
    const double radius = 1.0, a = 0.3;
    const auto speed = [&](double r) {
        return r > a && r < radius ? radius * radius - r * r + (radius * radius - a * a) * std::log(r / radius) / std::log(radius / a)
                                   : 0.0;
    };
    geometry::FlowImage flow;
    flow.grid.cells = {400, 400, 2};
    flow.grid.origin_m = {-1.0, -1.0, 0.0};
    flow.grid.spacing_m = {0.005, 0.005, 0.5};
    flow.velocity_m_per_s.assign(3 * flow.grid.size(), 0.0F);
    for (std::size_t cell = 0; cell < flow.grid.size(); ++cell) {
        const auto at = flow.grid.place(cell);
        flow.velocity_m_per_s[3 * cell + 2] = static_cast<float>(speed(std::hypot(flow.grid.centre(0, at[0]), flow.grid.centre(1, at[1]))));
    }
    const auto integral = [&](double r0, double r1) {  // of u r, by 2000 midpoints
        double sum = 0.0;
        for (int i = 0; i < 2000; ++i) {
            const double r = r0 + (r1 - r0) * (i + 0.5) / 2000.0;
            sum += speed(r) * r * (r1 - r0) / 2000.0;
        }
        return sum;
    };
    const double mean = 2.0 * integral(0.0, radius);
    for (const lbm::Ring& ring : lbm::radial_profile(flow, {0.0, 1.0}, 2.0 * radius, 10)) {
        const double area = 0.5 * (ring.r1_m * ring.r1_m - ring.r0_m * ring.r0_m);
        EXPECT_NEAR(ring.relative_velocity, integral(ring.r0_m, ring.r1_m) / area / mean, 0.02) << ring.r0_m;
        EXPECT_NEAR(ring.porosity, ring.r0_m < a - 1e-9 ? 0.0 : 1.0, 0.01) << ring.r0_m;
    }
    const double core = integral(0.0, 0.7) / (0.5 * 0.49) / mean;
    EXPECT_NEAR(lbm::core_over_tube(flow, {0.0, 1.0}, 2.0 * radius, 0.3) / core, 1.0, 2e-3);
    EXPECT_TRUE(std::isnan(lbm::core_over_tube(flow, {0.0, 1.0}, 2.0 * radius, 1.5)));
}

}  // namespace
}  // namespace porepack
