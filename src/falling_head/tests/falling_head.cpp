#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "falling_head/falling_head.hpp"
#include "support/basics.hpp"

namespace porepack {
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

}  // namespace
}  // namespace porepack
