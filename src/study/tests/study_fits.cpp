// Derived columns, formulas and fits of a study.
#include "study/study_fits.hpp"
#include "core/error.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/table.hpp"
#include "study/formula.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

using namespace study;

std::vector<StudyRow> rows_of(const std::vector<double>& x, const std::function<double(double)>& y) {
    std::vector<StudyRow> rows;
    for (const double at : x) rows.push_back({{"point", "p"}, {"x", fmt::format("{:.15g}", at)}, {"y", fmt::format("{:.15g}", y(at))}});
    return rows;
}
const std::vector<double> places = {0.4, 0.5, 0.55, 0.62, 0.7, 0.78};

TEST(Formula, IsArithmeticAndNothingElse) {
    const Formula formula("2*a^2 - log(b)/exp(1) + sqrt(abs(-4)) + log10(100)**2", {"a", "b"}, "here");
    EXPECT_NEAR(formula(std::array{3.0, 2.0}), 18.0 - std::log(2.0) / std::exp(1.0) + 2.0 + 4.0, 1e-12);
    EXPECT_EQ(Formula("2*b", {"a", "b"}, "here").used(), std::vector<std::string>{"b"});
    for (const char* text : {"", "c", "a = 3", "system(\"id\")", "`id`", "a; b", "a < b ? 1 : 2", "sin(a)", "_pi", "a +", "(a"})
        EXPECT_THROW((void)Formula(text, {"a", "b"}, "here"), core::UserError) << text;
}

TEST(Columns, FollowFromOthers) {
    StudyConfig config;
    config.columns = {{"ratio", "y/x"}, {"twice_ratio", "2*ratio"}};
    std::vector<StudyRow> rows = {{{"x", "4"}, {"y", "8"}}, {{"x", ""}, {"y", "8"}}, {{"x", "0"}, {"y", "1"}}};
    rows = with_columns(rows, config);
    EXPECT_EQ(rows[0]["twice_ratio"], "4");
    EXPECT_EQ(rows[1]["ratio"], "") << "a variable is missing";
    EXPECT_EQ(rows[2]["ratio"], "") << "infinite";
    config.columns = {{"y", "2*x"}};
    EXPECT_THROW((void)with_columns(rows, config), core::UserError) << "the table has such a column";
    config.columns = {{"z", "2*w"}};
    EXPECT_THROW((void)with_columns(rows, config), core::UserError);
}

TEST(Fits, FindTheCurvesOfExactPoints) {
    const auto one = [](CurveForm form, long degree, const std::function<double(double)>& y) {
        return fitted_curves(rows_of(places, y), {.name = "f", .x = "x", .y = "y", .form = form, .degree = degree}).at(0);
    };
    const FittedCurve cubic = one(CurveForm::polynomial, 3, [](double x) { return 1.0 - 2.0 * x + 0.5 * x * x * x; });
    EXPECT_NEAR(cubic.coefficients[1].value, -2.0, 1e-8);
    EXPECT_NEAR(cubic.coefficients[3].value, 0.5, 1e-8);
    EXPECT_NEAR(cubic.value(0.6), 1.0 - 1.2 + 0.108, 1e-10);
    EXPECT_NEAR(cubic.r_squared, 1.0, 1e-12);
    const FittedCurve eq_22 = one(CurveForm::exponential, 1, [](double x) { return 5.3e-9 * std::exp(7.3 * x); });
    EXPECT_NEAR(eq_22.coefficients[0].value / 5.3e-9, 1.0, 1e-9);
    EXPECT_NEAR(eq_22.coefficients[1].value, 7.3, 1e-9);
    EXPECT_EQ(eq_22.text, "5.3e-09 exp(7.3 x)");
    EXPECT_NEAR(one(CurveForm::power, 1, [](double x) { return 3.0 * std::pow(x, 2.5); }).coefficients[1].value, 2.5, 1e-9);
    EXPECT_NEAR(one(CurveForm::logarithmic, 1, [](double x) { return 1.0 - 1.5 * std::log(x); }).coefficients[1].value, -1.5, 1e-9);
}

TEST(Fits, ResidualsOfAGivenCurve) {
    const std::vector<StudyRow> rows = rows_of(places, [](double x) { return x; });
    FitConfig fit{.name = "f", .x = "x", .y = "y", .form = CurveForm::given, .formula = "1.1*x"};
    fit.relative = true;
    const FittedCurve curve = fitted_curves(rows, fit).at(0);
    EXPECT_NEAR(curve.bias, std::log(1.1), 1e-12);
    EXPECT_NEAR(curve.residual, std::log(1.1), 1e-12);
    EXPECT_TRUE(curve.coefficients.empty());
}

TEST(Fits, IntervalsHoldTheTruth) {
    // Straight lines with noise: intervals of 95 % hold the slope in 95 % of 2000, standard error 0.5 %.
    std::mt19937_64 random(11);
    std::normal_distribution<double> noise(0.0, 0.05);
    int held = 0;
    for (int i = 0; i < 2000; ++i) {
        const auto curve = fitted_curves(rows_of(places, [&](double x) { return 2.0 + 3.0 * x + noise(random); }),
                                         {.name = "f", .x = "x", .y = "y", .form = CurveForm::polynomial, .degree = 1})
                               .at(0);
        held += curve.coefficients[1].interval.low <= 3.0 && 3.0 <= curve.coefficients[1].interval.high ? 1 : 0;
    }
    EXPECT_NEAR(held / 2000.0, 0.95, 0.02);
}

TEST(Fits, ByGroupAndWithTooFewPoints) {
    std::vector<StudyRow> rows = rows_of(places, [](double x) { return 2.0 * x; });
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i]["shape"] = i < 4 ? "a" : "b";
    const auto curves = fitted_curves(rows, {.name = "f", .x = "x", .y = "y", .by = "shape", .form = CurveForm::polynomial, .degree = 2});
    ASSERT_EQ(curves.size(), 2U);
    EXPECT_TRUE(curves[0].value && curves[0].points == 4);
    EXPECT_FALSE(curves[1].value) << curves[1].text;
    rows[0]["y"] = "-1";
    EXPECT_THROW((void)fitted_curves(rows, {.name = "f", .x = "x", .y = "y", .form = CurveForm::exponential}), core::UserError);
    const test::Folder folder;
    write_fits(curves, folder.path() / "fits.csv");
    EXPECT_EQ(read_text_table(folder.path() / "fits.csv").rows.size(), 3U) << "three coefficients of the one that has enough points";
}

}  // namespace
}  // namespace porepack
