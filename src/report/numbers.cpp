// How the report writes numbers and intervals.
#include <cmath>
#include <optional>
#include <regex>
#include <string>

#include "report/section.hpp"
#include "report/uses.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::report {

std::string with_powers_of_ten(const std::string& text) {
    static const std::regex power("([0-9])e([+-])0*([0-9]+)");  // of a number
    constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string result;
    auto rest = text.cbegin();
    for (std::sregex_iterator match(text.begin(), text.end(), power), end; match != end; ++match) {
        result.append(rest, (*match)[1].second).append("\u00a0×\u00a010").append((*match)[2] == "-" ? "⁻" : "");
        for (const char digit : (*match)[3].str()) result += digits[digit - '0'];
        rest = (*match)[0].second;
    }
    result.append(rest, text.cend());
    // The unit stays with its number.
    if (const std::size_t unit = result.find(" m"); unit != std::string::npos && unit + 2 < result.size() && rest != text.cbegin())
        result.replace(unit, 1, "\u00a0");
    return result;
}

std::string number_text(std::optional<double> value, const char* format) {
    return value && std::isfinite(*value) ? with_powers_of_ten(fmt::format(fmt::runtime(format), *value)) : dash;
}

std::string interval_text(const std::optional<Interval>& interval) {
    return interval ? fmt::format("{} to {}", number_text(interval->low), number_text(interval->high)) : "none";
}

std::string percent_text(double value, const Interval& interval) {
    const Sides percent = 100.0 / std::abs(value) * half_widths(value, interval);
    // A porosity from exact grains has only the error of the quadrature: its digits would say nothing.
    if (percent.wider() < min_percent_shown) return "(exact to these digits)";
    constexpr double rounding = 1e-6;  // of a symmetric interval, far below the digits shown
    if (std::abs(percent.below - percent.above) <= rounding * percent.wider())
        return fmt::format("± {:.2g} %", 0.5 * (percent.below + percent.above));
    const std::string below = fmt::format("{:.2g}", percent.below), above = fmt::format("{:.2g}", percent.above);
    return below == above ? fmt::format("± {} %", below) : fmt::format("(− {} %, + {} %)", below, above);
}

std::string difference(std::optional<double> value, std::optional<double> reference) {
    if (!value || !reference) return dash;
    const double percent = 100.0 * (*value / *reference - 1.0);
    constexpr double half_a_digit = 0.05;
    return std::abs(percent) < half_a_digit ? "0.0 %" : fmt::format("{:+.1f} %", percent);
}

std::optional<Interval> two_standard_uncertainties(double value, double standard_uncertainty) {
    if (!std::isfinite(standard_uncertainty)) return std::nullopt;
    const double half = 2.0 * standard_uncertainty;
    return about(value, {half, half});
}

std::optional<Interval> interval_of_path_mean(double mean, double standard_error, long number) {
    if (!std::isfinite(standard_error) || number < 2) return std::nullopt;
    const double half = uncertainty::students_t(static_cast<double>(number) - 1.0) * standard_error;
    return about(mean, {half, half});
}

}  // namespace porepack::report
