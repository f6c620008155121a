// The first lines of the report.
#include <cmath>
#include <string>

#include "report/section.hpp"
#include "support/basics.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::report {
namespace {

using core::Interval;
using test::has;
using uncertainty::BudgetRow;
using uncertainty::Part;

// With plain spaces in numbers.
std::string plain(std::string text) {
    const std::string no_break = "\u00a0";
    for (std::size_t at = 0; (at = text.find(no_break, at)) != std::string::npos;) text.replace(at, no_break.size(), " ");
    return text;
}

ReportInput one_packing() {
    ReportInput input;
    input.results.pack.emplace();
    results::Uncertainty& sure = input.results.uncertainty.emplace();
    results::Statements k, porosity;
    k.this_packing = {.value = 1.24e-6, .interval = Interval{1.235e-6, 1.245e-6}};
    porosity.this_packing = {.value = 0.758};
    sure.statements = {{"permeability_m2", k}, {"porosity", porosity}};
    sure.budget_of_permeability = {{.source = "grid", .relative_standard_uncertainty = {0.003, 0.003}, .part = Part::numerical},
                                   {.source = "hint", .relative_standard_uncertainty = {0.5, 0.5}, .part = Part::hint}};
    return input;
}

ReportInput three_packings() {
    ReportInput input = one_packing();
    results::Statements& k = input.results.uncertainty->statements.front().second;
    k.mean_of_such_packings = {.value = 1.13e-6, .interval = Interval{7.3e-7, 1.53e-6}, .packings = 3};
    k.next_such_packing = {.value = 1.13e-6, .interval = Interval{3.3e-7, 1.93e-6}, .packings = 3};
    input.results.uncertainty->budget_of_permeability.push_back(
        {.source = "packing to packing", .relative_standard_uncertainty = {0.004, 0.004}, .part = Part::scatter});
    input.results.seeds = {.packings = 3, .permeability_mean_m2 = 1.0e-6, .standard_deviation_between_packings_m2 = 1.5e-7};
    input.manifests["seeds"] = {{"wall_time_s", 120.0}};
    return input;
}

TEST(Answer, OfOnePackingSaysThatOthersAreNotKnown) {
    const Answer answer = answer_of(one_packing());
    ASSERT_EQ(answer.sentences.size(), 2U);
    EXPECT_EQ(plain(answer.sentences[0]), "k of this packing is 1.24 × 10⁻⁶ m² ± 0.4 %; its porosity is 0.7580, no uncertainty known.");
    EXPECT_TRUE(has(answer.sentences[1], "--until-sure"));
    EXPECT_TRUE(answer.shares.empty());
    EXPECT_TRUE(answer_of({}).sentences.empty());
}

TEST(Answer, OfSeveralPackingsIsAboutSuchPackings) {
    const ReportInput input = three_packings();
    const Answer answer = answer_of(input);
    ASSERT_EQ(answer.sentences.size(), 3U);
    EXPECT_TRUE(has(plain(answer.sentences[0]), "k of such packings is 1.13 × 10⁻⁶ m² on average, 7.3 × 10⁻⁷ to 1.5 × 10⁻⁶ m²"))
        << answer.sentences[0];
    EXPECT_TRUE(has(plain(answer.sentences[0]), "3.3 × 10⁻⁷ to 1.9 × 10⁻⁶ m²")) << answer.sentences[0];
    // By the definition of the interval of a mean; a minute per packing.
    std::size_t wanted = 3;
    while (uncertainty::students_t(static_cast<double>(wanted - 1)) * 0.15 > 0.1 * std::sqrt(static_cast<double>(wanted))) ++wanted;
    EXPECT_GT(wanted, 5U);
    EXPECT_TRUE(has(answer.sentences[2], fmt::format("About {} more packings", wanted - 3))) << answer.sentences[2];
    EXPECT_TRUE(has(answer.sentences[2], fmt::format("{} min", wanted - 3))) << answer.sentences[2];
    ASSERT_EQ(answer.shares.size(), 2U);  // without the hint
    EXPECT_NEAR(answer.shares[0].second, 0.36, 1e-12);
    EXPECT_NEAR(answer.shares[1].second, 0.64, 1e-12);
    ReportInput sure = input;
    sure.results.seeds->standard_deviation_between_packings_m2 = 1e-8;
    EXPECT_TRUE(has(answer_of(sure).sentences[2], "allows a mean to ± 10 %"));
}

}  // namespace
}  // namespace porepack::report
