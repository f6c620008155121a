// How sure the numbers are: this packing, the mean of such packings, the next one; and the uncertainty budget of k.
#include <cmath>

#include "core/table.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"
#include "uncertainty/quantities.hpp"

namespace porepack::report {
using namespace core;
using namespace permeability;
using namespace uncertainty;
namespace {

const Json& statement_at(const ReportInput& input, const std::string& quantity, const char* which) {
    return result_at(input, "uncertainty/statements/" + quantity + "/" + which);
}

// "1.24e-06 m² ± 1.2 %": the percentage says more than two limits.
std::string with_interval(const Json& statement, const char* format, const std::string& unit = {}) {
    if (!statement.is_object()) return "–";
    if (!statement["value"].is_number()) return "not known";
    const double value = statement["value"].get<double>();
    const Json& interval = statement["interval"];
    const std::string number = with_powers_of_ten(fmt::format(fmt::runtime(format), value) + (unit.empty() ? "" : " " + unit));
    if (!interval.is_array()) return number + ", no uncertainty known";
    return number + " " + percent_text(value, {interval[0].get<double>(), interval[1].get<double>()});
}

std::string measured_bed_text(const Json& bed) {
    const Json& part = bed["measured_part"];
    std::string text = fmt::format(
        " The bed of measured porosity: k of the bed that exists, whose porosity ({}) is {:g} with a standard uncertainty of {:g}, from "
        "the "
        "line of ln k on the porosity of the packings.",
        part == "section" ? "of the section"
        : part == "bed"   ? "of the whole bed"
                          : "between two levels",
        bed["measured_porosity"].get<double>(), bed["measured_standard_uncertainty"].get<double>());
    if (bed.contains("why")) text += " It is not known: " + bed["why"].get<std::string>() + ".";
    return text;
}

}  // namespace

std::string sure_text(const ReportInput& input, const std::string& quantity, const char* which) {
    for (const Quantity& row : reported_quantities)
        if (quantity == row.name) return with_interval(statement_at(input, quantity, which), row.format, row.unit);
    return "–";
}

ReportSection uncertainty_section(const ReportInput& input) {
    ReportSection section{.title = "How sure is that?"};
    if (!result_at(input, "uncertainty/statements").is_object()) return section;
    section.intro =
        "Intervals of 95 %. This packing: the errors of the computation alone. The mean of such packings: the mean over other seeds of the "
        "same case. The next such packing: where k of one more packing lies.";
    const Json &k_mean = statement_at(input, "permeability_m2", "mean_of_such_packings"), &seeds = result_at(input, "seeds/packings");
    if (k_mean.is_object() && k_mean.contains("why"))
        section.intro += " Mean and next packing are " + k_mean["why"].get<std::string>() +
                         ". [packings] seeds = 5 or `porepack run --until-sure 0.05` tells.";
    if (const Json& unseen = result_at(input, "seeds/unseen_share"); unseen.is_number())
        section.intro += fmt::format(
            " Mean and next packing presume that the {} packings show the scatter: with a probability of 5 %, packings of another kind "
            "that make up "
            "{:.2g} % of all are absent.",
            seeds.get<long>(), 100.0 * unseen.get<double>());
    const Json& weighed = statement_at(input, "permeability_m2", "bed_of_measured_porosity");
    if (weighed.is_object()) section.intro += measured_bed_text(weighed);
    const std::string n = seeds.is_number() ? fmt::format(" (n = {})", seeds.get<long>()) : "";
    section.header = {"quantity", "this packing (n = 1)", "mean of such packings" + n, "next such packing" + n};
    if (weighed.is_object())
        section.header.push_back(fmt::format("the bed of measured porosity {:g}", weighed["measured_porosity"].get<double>()));
    for (const Quantity& row : reported_quantities) {
        const Json& here = statement_at(input, row.name, "this_packing");
        if (!here.is_object()) continue;
        section.rows.push_back({row.label, with_interval(here, row.format),
                                with_interval(statement_at(input, row.name, "mean_of_such_packings"), row.format),
                                with_interval(statement_at(input, row.name, "next_such_packing"), row.format)});
        if (weighed.is_object())
            section.rows.back().push_back(with_interval(statement_at(input, row.name, "bed_of_measured_porosity"), row.format));
    }
    return section;
}

namespace {

std::string standard_uncertainty_text(const Json& sides) {
    const auto percent = [](double u) {
        return u == 0.0 ? std::string("0") : u < 1e-5 ? std::string("< 0.001 %") : fmt::format("{:.2g} %", 100.0 * u);
    };
    const double below = sides["below"].get<double>(), above = sides["above"].get<double>();
    if (below == above) return below == 0.0 ? "< 0.001 %" : percent(below);
    return fmt::format("{} below, {} above", percent(below), percent(above));
}

}  // namespace

ReportSection budget_section(const ReportInput& input) {
    ReportSection section{.title = "Uncertainty budget of k"};
    const Json& rows = result_at(input, "uncertainty/budget_of_permeability");
    if (!rows.is_array()) return section;
    section.intro =
        "Standard uncertainties u (one standard deviation, not the 95 % of the statements) of k of one packing, below and above k where "
        "they differ. Numerical contributions are in all statements above. An uncertain input, as friction, is in those about the mean and "
        "the next packing. "
        "The scatter between packings is in these two. A hint is in none: it suggests the scatter where only one packing is known, or "
        "shows what half the resolution of an image does to k.";
    section.header = {"contribution", "u(k)/k", "part", "evidence", "from"};
    for (const Json& row : rows)
        section.rows.push_back({row["source"].get<std::string>(), standard_uncertainty_text(row["sides"]), row["part"].get<std::string>(),
                                row["evidence"].get<std::string>(), with_powers_of_ten(row["origin"].get<std::string>())});
    return section;
}

void add_budget_picture(const ReportInput& input, const Path& folder, ReportSection& section) {
    const Json& rows = result_at(input, "uncertainty/budget_of_permeability");
    if (!rows.is_array() || rows.empty()) return;
    Table table({"contribution", "percent", "part"});
    for (const Json& row : rows) {
        const auto part = row["part"].get<std::string>();
        table.add(row["source"].get<std::string>(), 100.0 * row["relative_standard_uncertainty"].get<double>(),
                  part == "numerical" ? 1
                  : part == "scatter" ? 2
                  : part == "hint"    ? 3
                                      : 4);
    }
    table.write(folder / "budget.csv");
    if (draw_plot(folder / "budget.svg", "budget", {{"count", static_cast<double>(rows.size())}},
                  {.width = 620, .height = 90 + 26 * static_cast<int>(rows.size())}))
        section.pictures.emplace_back("budget.svg",
                                      "Contributions to the uncertainty of k: numerical (blue), scatter between packings (orange), "
                                      "uncertain input (red), hint (grey). Those below 0.001 % "
                                      "are drawn at 0.001 %.");
}

}  // namespace porepack::report
