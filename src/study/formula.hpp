// Formulas of study.toml.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace porepack::study {

/// Arithmetic of named variables: + - * / ^ (or **), brackets, exp, log (natural), log10, sqrt, abs.
class Formula {
public:
    /// Throws UserError for anything else. `where` names the formula's place for messages.
    Formula(const std::string& text, const std::vector<std::string>& variables, const std::string& where);
    ~Formula();
    Formula(Formula&&) noexcept;
    Formula& operator=(Formula&&) noexcept;

    /// Values in the order of the variables. NaN or infinite where the formula has no value.
    [[nodiscard]] double operator()(std::span<const double> values) const;
    /// Those of the variables that occur in the formula.
    [[nodiscard]] std::vector<std::string> used() const;

private:
    struct Parser;
    std::unique_ptr<Parser> parser_;
};

}  // namespace porepack::study
