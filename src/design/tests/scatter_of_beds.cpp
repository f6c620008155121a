// Intervals from the scatter of one bed and of others.
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "design/scatter.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

using design::BedScatter;
using design::ScatterOfBeds;

// k of the beds of cases/paper_study, three packings each: tetrahedron 0.53 has 2.49 %, dolos 0.47 is the last.
std::vector<BedScatter> measured_beds() {
    std::vector<BedScatter> beds;
    for (const double s : {0.0249, 0.1009, 0.0981, 0.0512, 0.0240, 0.0073, 0.0076, 0.0420, 0.0057, 0.1023, 0.0967, 0.0278,
                           0.0255, 0.0437, 0.0342, 0.0347, 0.0503, 0.0319, 0.0597, 0.0272, 0.0460, 0.0505, 0.0128, 0.2774})
        beds.push_back({s, 3});
    return beds;
}

// The mean of t intervals over d0 and s0, computed by another program (scipy) with 400 nodes in d0/(d0 + 2) and steps of 0.02 in ln s0.
// The sums of this one have 16 nodes and steps of 0.1, which agree to 0.1 %; rounded deviations to 0.1 %, and more for small ones.
TEST(ScatterOfBeds, AgreesWithAnotherProgram) {
    const std::vector<BedScatter> beds = measured_beds();
    const ScatterOfBeds scatter(beds);
    EXPECT_NEAR(scatter.typical().value(), 0.03873, 0.0001);
    EXPECT_NEAR(scatter.common_weight().value(), 0.5332, 0.002);
    EXPECT_NEAR(scatter.half_width(beds.front()) / 0.05363, 1.0, 0.005);
    EXPECT_NEAR(scatter.half_width(beds.back()) / 0.30418, 1.0, 0.005);
    const std::vector<BedScatter> mixed = {{0.1, 2}, {0.02, 3}, {0.05, 5}, {0.2, 12}};
    const std::vector<double> half_widths = {0.22926, 0.096736, 0.071619, 0.116726};
    for (std::size_t i = 0; i < mixed.size(); ++i) EXPECT_NEAR(ScatterOfBeds(mixed).half_width(mixed[i]) / half_widths[i], 1.0, 0.005) << i;
}

// Another bed, of a large scatter, changes the interval of a bed little; a pooled deviation would grow by 40 %.
TEST(ScatterOfBeds, OtherBedsMoveAnIntervalLittle) {
    std::vector<BedScatter> beds = measured_beds();
    const double with = ScatterOfBeds(beds).half_width(beds.front());
    beds.pop_back();
    EXPECT_NEAR(ScatterOfBeds(beds).half_width(beds.front()) / with, 1.0, 0.02);  // 0.4 % by the other program
}

TEST(ScatterOfBeds, OneBedHasItsOwnInterval) {
    // t(0.975) = 12.7062 and 4.30265. The range of ln s0 ends: that changes the interval of two packings by 1.5 %, of three by 0.7 %.
    EXPECT_NEAR(ScatterOfBeds({{0.1, 2}}).half_width({0.1, 2}) / (12.7062 * 0.1 / std::sqrt(2.0)), 1.0, 0.02);
    EXPECT_NEAR(ScatterOfBeds({{0.1, 3}, {0.0, 1}}).half_width({0.1, 3}) / (4.30265 * 0.1 / std::sqrt(3.0)), 1.0, 0.01);
    EXPECT_NEAR(ScatterOfBeds({{1e-4, 3}}).half_width({1e-4, 3}) / ScatterOfBeds({{0.1, 3}}).half_width({0.1, 3}), 1e-3, 1e-9) << "units";
    // No bed has several packings: the t interval of the deviation that is expected.
    const ScatterOfBeds nothing({{0.0, 1}, {0.0, 1}});
    EXPECT_FALSE(nothing.typical() || nothing.common_weight());
    EXPECT_NEAR(nothing.half_width({0.1, 3}), 4.30265 * 0.1 / std::sqrt(3.0), 1e-6);
    // Packings that are equal take the scatter of the others.
    EXPECT_GT(ScatterOfBeds({{0.0, 3}, {0.05, 3}, {0.04, 3}}).half_width({0.0, 3}), 0.02);
}

struct Held {
    double some, largest, largest_pooled;
};

// Studies of 24 beds; the shares of intervals that hold the mean: of eight of them, and of the bed with the largest true deviation.
Held coverage(const std::function<double(std::mt19937_64&)>& deviation, long packings, unsigned seed) {
    constexpr int studies = 200;
    constexpr std::size_t count = 24, some = 8;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const double n = static_cast<double>(packings);
    std::chi_squared_distribution<double> squares(n - 1.0);
    Held held{};
    for (int i = 0; i < studies; ++i) {
        std::vector<BedScatter> beds;
        std::vector<double> sigma, error;
        double variance = 0.0;
        for (std::size_t bed = 0; bed < count; ++bed) {
            sigma.push_back(deviation(random));
            error.push_back(std::abs(sigma.back() * normal(random)) / std::sqrt(n));
            beds.push_back({sigma.back() * std::sqrt(squares(random) / (n - 1.0)), packings});
            variance += beds.back().deviation * beds.back().deviation / count;
        }
        const ScatterOfBeds scatter(beds);
        const auto largest = static_cast<std::size_t>(std::max_element(sigma.begin(), sigma.end()) - sigma.begin());
        const auto is_held = [&](std::size_t bed) { return scatter.chance_beyond(beds[bed], error[bed]) >= 0.05 ? 1.0 : 0.0; };
        for (std::size_t bed = 0; bed < some; ++bed) held.some += is_held(bed) / (studies * some);
        held.largest += is_held(largest) / studies;
        constexpr double smallest_t = 1.96;  // of the pooled deviation with 24 to 96 degrees of freedom: 1.98 to 2.06
        held.largest_pooled += error[largest] <= 1.05 * smallest_t * std::sqrt(variance / n) ? 1.0 / studies : 0.0;
    }
    return held;
}

// Beds that scatter by 0.6 to 28 %, by the distribution that the method assumes and by two others. 1600 intervals have a standard error of
// 0.6 %; the 200 largest, 2 to 3 %. `porepack_benchmark design-scatter` has
// the table. The bed that scatters most is covered less, whatever the method: its deviation is shrunk. The bounds are those of the table
// less three standard errors.
TEST(ScatterOfBeds, IntervalsHoldTheMeansOfBedsThatScatterDifferently) {
    const std::vector<std::function<double(std::mt19937_64&)>> spreads = {
        [](auto& random) { return 0.038 * std::sqrt(2.2 / std::chi_squared_distribution<double>(2.2)(random)); },
        [](auto& random) { return 0.049 * std::exp(0.65 * std::normal_distribution<double>()(random)); },
        [](auto& random) { return std::exp(std::uniform_real_distribution<double>(std::log(0.006), std::log(0.28))(random)); }};
    unsigned seed = 4711;
    for (const auto& spread : spreads)
        for (const auto& [packings, smallest_of_largest] : {std::pair(2L, 0.62), {3L, 0.71}, {5L, 0.78}}) {
            const Held held = coverage(spread, packings, ++seed);
            EXPECT_NEAR(held.some, 0.95, 0.02) << packings << ' ' << seed;
            EXPECT_GE(held.largest, smallest_of_largest) << packings << ' ' << seed;
            EXPECT_GT(held.largest, held.largest_pooled + 0.03) << packings << ' ' << seed << ": the pooled deviation holds it less";
        }
}

// The half width is where the probability is 5 %, and shrinks with the number of packings.
TEST(ScatterOfBeds, HalfWidthsAreQuantiles) {
    const std::vector<BedScatter> beds = measured_beds();
    const ScatterOfBeds scatter(beds);
    for (const BedScatter& bed : beds) EXPECT_NEAR(scatter.chance_beyond(bed, scatter.half_width(bed)), 0.05, 1e-6);
    EXPECT_LT(scatter.half_width({0.05, 12}), 0.5 * scatter.half_width({0.05, 3}));
}

}  // namespace
}  // namespace porepack
