#include "study/study_fits.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/table.hpp"
#include "study/formula.hpp"
#include "study/uses.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::study {
namespace {

struct Points {
    std::vector<double> x, y;
};

// By group, in the order of the table.
std::vector<std::pair<std::string, Points>> grouped(const std::vector<StudyRow>& rows, const FitConfig& fit) {
    const std::string x = column_named(rows, fit.x), y = column_named(rows, fit.y);
    const std::string by = fit.by.empty() ? std::string() : column_named(rows, fit.by);
    std::vector<std::pair<std::string, Points>> groups;
    for (const StudyRow& row : rows) {
        const double at = number_in(row, x), value = number_in(row, y);
        if (!std::isfinite(at) || !std::isfinite(value)) continue;
        const std::string name = by.empty() ? std::string() : row.at(by);
        auto found = std::find_if(groups.begin(), groups.end(), [&](const auto& one) { return one.first == name; });
        if (found == groups.end()) found = groups.insert(groups.end(), {name, {}});
        found->second.x.push_back(at);
        found->second.y.push_back(value);
    }
    return groups;
}

bool takes_logarithm_of_y(CurveForm form) {
    return form == CurveForm::exponential || form == CurveForm::power;
}
bool takes_logarithm_of_x(CurveForm form) {
    return form == CurveForm::logarithmic || form == CurveForm::power;
}

double logarithm(double value, const FitConfig& fit, const char* what) {
    if (!(value > 0.0))
        throw UserError(fmt::format("the fit \"{}\" needs positive {}, and {:.4g} is not", fit.name, what, value),
                        {.where = "study.toml, [[fit]]", .fix = "form = \"polynomial\""});
    return std::log(value);
}

struct LeastSquares {
    Eigen::VectorXd coefficients, deviations;
    double residual = 0.0, r_squared = 0.0, freedom = 0.0;
};

LeastSquares least_squares(const Eigen::MatrixXd& terms, const Eigen::VectorXd& y) {
    // QR for the coefficients, because the normal equations square the condition number of polynomial terms. The covariance is residual^2
    // (T^T T)^-1, with the residual's degrees of freedom.
    LeastSquares result;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(terms);
    result.coefficients = factor.solve(y);
    const double squares = (y - terms * result.coefficients).squaredNorm(), all = (y.array() - y.mean()).square().sum();
    result.freedom = static_cast<double>(terms.rows() - terms.cols());
    result.residual = std::sqrt(squares / result.freedom);
    result.r_squared = all > 0.0 ? 1.0 - squares / all : 1.0;
    result.deviations = result.residual * (terms.transpose() * terms).inverse().diagonal().cwiseSqrt();
    return result;
}

std::string text_of(CurveForm form, const std::vector<Coefficient>& c) {
    const auto signed_term = [](double value, const std::string& factor) {
        return fmt::format(" {} {:.4g}{}", value < 0.0 ? "-" : "+", std::abs(value), factor);
    };
    if (form == CurveForm::exponential) return fmt::format("{:.4g} exp({:.4g} x)", c[0].value, c[1].value);
    if (form == CurveForm::power) return fmt::format("{:.4g} x^{:.4g}", c[0].value, c[1].value);
    std::string text = fmt::format("{:.4g}", c[0].value);
    for (std::size_t i = 1; i < c.size(); ++i)
        text += signed_term(c[i].value, form == CurveForm::logarithmic ? " ln x" : i == 1 ? " x" : fmt::format(" x^{}", i));
    return text;
}

FittedCurve fitted(const FitConfig& fit, const Points& points) {
    const auto n = static_cast<Eigen::Index>(points.x.size());
    const Eigen::Index count = fit.form == CurveForm::polynomial ? fit.degree + 1 : 2;
    if (n <= count) return {.text = fmt::format("{} coefficients need {} points or more", count, count + 1)};
    // Polynomials about the middle of x would be better conditioned, but their coefficients are not those of the literature.
    Eigen::MatrixXd terms(n, count);
    Eigen::VectorXd y(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const double at = points.x[static_cast<std::size_t>(i)], value = points.y[static_cast<std::size_t>(i)];
        const double t = takes_logarithm_of_x(fit.form) ? logarithm(at, fit, "x") : at;
        for (Eigen::Index j = 0; j < count; ++j) terms(i, j) = std::pow(t, static_cast<double>(j));
        y[i] = takes_logarithm_of_y(fit.form) ? logarithm(value, fit, "y") : value;
    }
    const LeastSquares solved = least_squares(terms, y);
    FittedCurve curve{.in_logarithm = takes_logarithm_of_y(fit.form), .residual = solved.residual, .r_squared = solved.r_squared};
    const double t = uncertainty::students_t(solved.freedom);
    for (Eigen::Index j = 0; j < count; ++j) {
        const double value = solved.coefficients[j], half = t * solved.deviations[j];
        Coefficient one{.name = fmt::format("c{}", j), .value = value, .interval = {value - half, value + half}};
        // ln c0 was fitted: its interval is transformed back, and is not symmetric about c0.
        if (curve.in_logarithm && j == 0) one = {one.name, std::exp(value), {std::exp(one.interval.low), std::exp(one.interval.high)}};
        curve.coefficients.push_back(one);
    }
    curve.text = text_of(fit.form, curve.coefficients);
    curve.value = [form = fit.form, c = curve.coefficients](double x) {
        if (form == CurveForm::exponential) return c[0].value * std::exp(c[1].value * x);
        if (form == CurveForm::power) return c[0].value * std::pow(x, c[1].value);
        const double at = form == CurveForm::logarithmic ? std::log(x) : x;
        double sum = 0.0;
        for (auto one = c.rbegin(); one != c.rend(); ++one) sum = sum * at + one->value;
        return sum;
    };
    return curve;
}

FittedCurve given(const FitConfig& fit, const Points& points) {
    FittedCurve curve{.in_logarithm = fit.relative, .text = fit.formula};
    const auto formula = std::make_shared<Formula>(fit.formula, std::vector<std::string>{"x"}, "study.toml, [[fit]] " + fit.name);
    curve.value = [formula](double x) { return (*formula)(std::span(&x, 1)); };
    const auto of = [&](double value) { return fit.relative ? logarithm(value, fit, "values") : value; };
    const auto n = static_cast<double>(points.x.size());
    double mean = 0.0, squares = 0.0, scatter = 0.0;
    for (const double y : points.y) mean += of(y) / n;
    for (std::size_t i = 0; i < points.x.size(); ++i) {
        const double difference = of(curve.value(points.x[i])) - of(points.y[i]);
        curve.bias += difference / n;
        squares += difference * difference;
        scatter += std::pow(of(points.y[i]) - mean, 2);
    }
    curve.residual = std::sqrt(squares / n);
    curve.r_squared = scatter > 0.0 ? 1.0 - squares / scatter : 1.0;
    return curve;
}

}  // namespace

double number_in(const StudyRow& row, const std::string& column) {
    const auto found = row.find(column);
    if (found == row.end() || found->second.empty()) return std::numeric_limits<double>::quiet_NaN();
    char* end = nullptr;
    const double value = std::strtod(found->second.c_str(), &end);
    if (*end != '\0')
        throw UserError(fmt::format("column `{}` is not a column of numbers", column), {.allowed = "numbers: " + found->second});
    return value;
}

std::vector<StudyRow> with_columns(std::vector<StudyRow> rows, const StudyConfig& config) {
    for (const ColumnConfig& column : config.columns) {
        // A formula's variables are names of columns; those with a dot ("shape.sphericity") have no place in one.
        std::set<std::string> names;
        for (const StudyRow& row : rows)
            for (const auto& [name, field] : row)
                if (name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == std::string::npos)
                    names.insert(name);
        const std::vector<std::string> variables(names.begin(), names.end());
        const std::string where = "study.toml, [[column]] " + column.name;
        if (column.name.empty()) throw UserError("a column needs a name", {.where = "study.toml, [[column]]"});
        if (names.contains(column.name))
            throw UserError(fmt::format("study.csv has a column `{}` of its own", column.name), {.where = where});
        // Columns of earlier [[column]] tables are among the variables, because the rows already hold them.
        const Formula formula(column.formula, variables, where);
        const std::vector<std::string> used = formula.used();
        for (StudyRow& row : rows) {
            // Only variables that the formula uses are read: other columns may hold text. Their value, 1, has no effect.
            std::vector<double> values(variables.size(), 1.0);
            for (const std::string& name : used)
                values[static_cast<std::size_t>(std::find(variables.begin(), variables.end(), name) - variables.begin())] =
                    number_in(row, name);
            const double value = formula(values);
            row[column.name] = std::isfinite(value) ? fmt::format("{:.9g}", value) : std::string();
        }
    }
    return rows;
}

std::vector<FittedCurve> fitted_curves(const std::vector<StudyRow>& rows, const FitConfig& fit) {
    std::vector<FittedCurve> curves;
    for (const auto& [group, points] : grouped(rows, fit)) {
        FittedCurve curve = fit.form == CurveForm::given ? given(fit, points) : fitted(fit, points);
        curve.fit = fit.name;
        curve.group = group;
        curve.points = points.x.size();
        const auto [low, high] = std::minmax_element(points.x.begin(), points.x.end());
        curve.x_low = *low;
        curve.x_high = *high;
        curves.push_back(std::move(curve));
    }
    if (curves.empty()) throw UserError(fmt::format("the fit \"{}\" has no points", fit.name), {.where = "study.toml, [[fit]]"});
    return curves;
}

void write_fits(const std::vector<FittedCurve>& curves, const Path& file) {
    Table table({"fit", "group", "points", "curve", "coefficient", "value", "low", "high", "residuals_of", "bias", "residual_deviation",
                 "r_squared"});
    table.digits = 6;
    for (const FittedCurve& curve : curves) {
        const char* of = curve.in_logarithm ? "ln y" : "y";
        const auto row = [&](const std::string& name, const std::optional<Coefficient>& c) {
            table.add(curve.fit, curve.group, curve.points, curve.text, name, c ? std::optional(c->value) : std::nullopt,
                      c ? std::optional(c->interval.low) : std::nullopt, c ? std::optional(c->interval.high) : std::nullopt, of, curve.bias,
                      curve.residual, curve.r_squared);
        };
        for (const Coefficient& c : curve.coefficients) row(c.name, c);
        if (curve.coefficients.empty() && curve.value) row("", std::nullopt);
    }
    table.write(file);
}

}  // namespace porepack::study
