#include "study/formula.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <muParser.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "study/uses.hpp"

namespace porepack::study {

struct Formula::Parser {
    mu::Parser parser;
    std::vector<double> values;
};

namespace {

double natural_logarithm(double x) {
    return std::log(x);
}
double common_logarithm(double x) {
    return std::log10(x);
}
double exponential(double x) {
    return std::exp(x);
}
double square_root(double x) {
    return std::sqrt(x);
}
double magnitude(double x) {
    return std::abs(x);
}

}  // namespace

Formula::Formula(const std::string& text, const std::vector<std::string>& variables, const std::string& where)
    : parser_(std::make_unique<Parser>()) {
    std::string expression = text;
    for (std::size_t at = 0; (at = expression.find("**", at)) != std::string::npos;) expression.replace(at, 2, "^");
    mu::Parser& parser = parser_->parser;
    parser_->values.resize(variables.size(), 1.0);
    try {
        parser.ClearFun();
        parser.ClearConst();
        parser.DefineFun("exp", exponential);
        parser.DefineFun("log", natural_logarithm);
        parser.DefineFun("log10", common_logarithm);
        parser.DefineFun("sqrt", square_root);
        parser.DefineFun("abs", magnitude);
        for (std::size_t i = 0; i < variables.size(); ++i) parser.DefineVar(variables[i], &parser_->values[i]);
        // Assignments, comparisons and text have no meaning here.
        if (expression.find_first_of("=<>!?:&|\"'`;,") != std::string::npos) throw mu::ParserError("a character is not allowed");
        parser.SetExpr(expression);
        (void)parser.Eval();
    } catch (const mu::ParserError& error) {
        throw UserError(
            fmt::format("the formula \"{}\" is not possible: {}", text, error.GetMsg()),
            {.where = where, .allowed = fmt::format("{}, numbers, + - * / ^, exp, log, log10, sqrt, abs", fmt::join(variables, ", "))});
    }
}

Formula::~Formula() = default;
Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;

double Formula::operator()(std::span<const double> values) const {
    std::copy(values.begin(), values.end(), parser_->values.begin());
    return parser_->parser.Eval();
}

std::vector<std::string> Formula::used() const {
    std::vector<std::string> names;
    for (const auto& [name, value] : parser_->parser.GetUsedVar()) names.push_back(name);
    return names;
}

}  // namespace porepack::study
