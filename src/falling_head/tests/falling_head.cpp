#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "falling_head/falling_head.hpp"
#include "permeability/fluid.hpp"
#include "permeability/permeability.hpp"
#include "support/basics.hpp"

namespace porepack {
using namespace core;
using namespace permeability;
using namespace falling_head;
namespace {

TEST(FallingHead, PassesTheLevelsAtTheIndependentTimes) {
    // Independent values for tetrapods of sphericity 0.53 at porosity 0.70.
    const FallingHead test(8.931320185e-7, 3.873579470e-3, {});
    EXPECT_NEAR(test.time_at(1.3), 0.42727431, 1e-8);
    EXPECT_NEAR(test.time_at(0.7), 1.44786669, 1e-8);
    EXPECT_NEAR(test.time_at(0.1), 3.00825823, 1e-8);
}

TEST(FallingHead, LevelAndTimeAreInverse) {
    for (const double k : {1e-10, 1e-7, 2e-6, 1e-4, 1e-2})
        for (const double k_in : {1e-3, 1.0, std::numeric_limits<double>::infinity()}) {
            const FallingHead test(k, k_in, {});
            for (const double level : {1.5, 1.0, 0.3, 0.01})
                EXPECT_NEAR(test.level_at(test.time_at(level)), level, 1e-10) << k << " " << k_in;
        }
}

TEST(FallingHead, XPlusLogX) {
    for (double y = -700.0; y < 1e6; y = y < 10.0 ? y + 0.37 : y * 1.7) {
        const double x = solve_x_plus_log_x(y);
        EXPECT_NEAR(x + std::log(x), y, 1e-12 * std::max(1.0, std::abs(y)));
    }
}

TEST(FallingHead, RefusesNonsense) {
    EXPECT_THROW(FallingHead(0.0, 1.0, {}), UserError);
    EXPECT_THROW(FallingHead(1e-8, -1.0, {}), UserError);
    EXPECT_THROW((void)FallingHead(1e-8, 1.0, {}).time_at(2.0), UserError);
}

TEST(Correlations, CarmanKozeny) {
    // Eq. 2 by hand: 0.53^2 * 0.0111867^2 * 0.343 / (150 * 0.09).
    // Water: 998.21 kg/m3 and 1.0016 mPa s at 20 C, 0.8900 mPa s at 25 C (IAPWS); air: 1.204 kg/m3, 18.1 uPa s.
    const Fluid water = fluid_at(FluidName::water, 20.0), air = fluid_at(FluidName::air, 20.0);
    EXPECT_NEAR(water.density_kg_per_m3, 998.21, 0.01);
    EXPECT_NEAR(water.viscosity_Pa_s, 1.0016e-3, 1e-7);
    EXPECT_NEAR(fluid_at(FluidName::water, 25.0).viscosity_Pa_s, 0.8900e-3, 1e-7);
    EXPECT_NEAR(fluid_at(FluidName::water, 100.0).density_kg_per_m3, 958.4, 0.1);
    EXPECT_NEAR(air.density_kg_per_m3, 1.204, 1e-3);
    EXPECT_NEAR(air.viscosity_Pa_s, 18.1e-6, 1e-7);
    EXPECT_NEAR(hydraulic_conductivity_m_per_s(1e-9, water), 1e-9 * 998.21 * 9.81 / 1.0016e-3, 1e-6);
    EXPECT_NEAR(carman_kozeny_m2(0.53, 0.0111867, 0.7, 150.0), 0.2809 * 1.25142e-4 * 0.343 / 13.5, 1e-11);
    EXPECT_NEAR(paper_fit_m2(0.7) / 8.784e-7, 1.0, 1e-3);
    // Ergun by hand: 0.7^3 * 0.53 * 0.0111867 / (1.75 * 0.3).
    EXPECT_NEAR(ergun_inertial_m(0.53, 0.0111867, 0.7) / 3.87358e-3, 1.0, 1e-5);
    // One darcy: 1 mPa s and 1 cm/s at 1 atm per cm.
    EXPECT_NEAR(darcy_m2 / (1e-3 * 1e-2 * 1e-2 / 101325.0), 1.0, 1e-6);
}

}  // namespace
}  // namespace porepack
