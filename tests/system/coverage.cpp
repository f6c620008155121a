// The benchmark of intervals on cases that a seed draws: every kind runs, and every case is counted once.
#include "core/json.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

TEST(CoverageBySeed, EveryKindRunsAndEveryCaseIsCounted) {
    const auto output = test::porepack("benchmark coverage --seed 4 --quick");
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const Json result = output.json();
    EXPECT_EQ(result["seed"], 4);
    ASSERT_EQ(result["kinds"].size(), 5U);
    for (const Json& kind : result["kinds"]) {
        const long held = kind["held"], missed = kind["missed"], without = kind["without_interval"];
        EXPECT_EQ(kind["cases"], 4) << kind;
        EXPECT_EQ(held + missed + without, 4) << kind;
        EXPECT_GE(held, 1) << kind;  // intervals of 95 % all miss the answer only if the answer or the interval is wrong
        EXPECT_EQ(kind["misses"].size(), static_cast<std::size_t>(missed)) << kind;
        EXPECT_EQ(kind["cases_without_interval"].size(), static_cast<std::size_t>(without)) << kind;
        for (const Json& miss : kind["misses"]) {
            EXPECT_NE(miss["case"], "") << kind;
            EXPECT_GT(miss["missed_by"], 0.0) << kind;
        }
        for (const Json& refused : kind["cases_without_interval"]) {
            EXPECT_NE(refused["case"], "") << kind;
            EXPECT_NE(refused["because"], "") << kind;
        }
        const Json& probability = kind["probability_interval"];
        EXPECT_LE(probability[0], static_cast<double>(held) / static_cast<double>(held + missed)) << kind;
        EXPECT_GE(probability[1], static_cast<double>(held) / static_cast<double>(held + missed)) << kind;
    }
}

}  // namespace
}  // namespace porepack
