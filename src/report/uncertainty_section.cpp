// How sure the numbers are: this packing, the mean of such packings, the next one; and the uncertainty budget of k.
#include <string>
#include <vector>

#include "core/table.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"
#include "results/quantities.hpp"

namespace porepack::report {
namespace {

const results::Statements* statements_about(const ReportInput& input, const std::string& quantity) {
    return input.results.uncertainty ? find(input.results.uncertainty->statements, quantity) : nullptr;
}

// "1.24e-06 m² ± 1.2 %": the percentage says more than two limits.
std::string with_interval(const results::Statement& statement, const char* format, const std::string& unit = {}) {
    if (!statement.value) return "not known";
    const std::string number = with_powers_of_ten(fmt::format(fmt::runtime(format), *statement.value) + (unit.empty() ? "" : " " + unit));
    return number + (statement.interval ? " " + percent_text(*statement.value, *statement.interval) : ", no uncertainty known");
}

std::string intro_of_measured_bed(const results::StatementOfBed& bed) {
    std::string text = fmt::format(
        " The bed of measured porosity: k of the bed that exists, whose porosity ({}) is {:g} with a standard uncertainty of {:g}, from "
        "the line of ln k on the porosity of the packings.",
        bed.measured_part == "section" ? "of the section"
        : bed.measured_part == "bed"   ? "of the whole bed"
                                       : "between two levels",
        bed.measured_porosity, bed.measured_standard_uncertainty);
    if (bed.statement.why) text += " It is not known: " + *bed.statement.why + ".";
    return text;
}

// Of a quantity, as in the main numbers: with its unit.
template <typename Pick>
std::string statement_text(const ReportInput& input, const std::string& quantity, const Pick& pick) {
    const results::Statements* statements = statements_about(input, quantity);
    const results::Statement* found = statements != nullptr ? pick(*statements) : nullptr;
    if (found == nullptr) return dash;
    for (const results::Quantity& row : results::reported_quantities)
        if (quantity == row.name) return with_interval(*found, row.format, row.unit);
    return dash;
}

}  // namespace

std::string statement_label(const ReportInput& input, const std::string& name, results::Statement results::Statements::*which) {
    using results::Statements;
    if (which == &Statements::this_packing) return name + ", this packing";
    if (which == &Statements::next_such_packing) return name + ", next packing";
    const auto& seeds = input.results.seeds;
    return name + (seeds ? fmt::format(", mean of {} packings", seeds->packings) : ", mean of such packings");
}

std::string sure_text(const ReportInput& input, const std::string& quantity, results::Statement results::Statements::*which) {
    return statement_text(input, quantity, [&](const results::Statements& all) { return &(all.*which); });
}

std::string measured_bed_text(const ReportInput& input, const std::string& quantity) {
    return statement_text(input, quantity, [](const results::Statements& all) {
        return all.bed_of_measured_porosity ? &all.bed_of_measured_porosity->statement : nullptr;
    });
}

ReportSection uncertainty_section(const ReportInput& input) {
    ReportSection section{.title = "How sure is that?"};
    const results::Statements* k = statements_about(input, "permeability_m2");
    if (k == nullptr) return section;
    const auto& seeds = input.results.seeds;
    section.intro =
        "Intervals of 95 %. This packing: the errors of the computation alone. The mean of such packings: the mean over other seeds of the "
        "same case. The next such packing: where k of one more packing lies.";
    if (const auto& why = k->mean_of_such_packings.why)
        section.intro += " Mean and next packing are " + *why + ". [packings] seeds = 5 or `porepack run --until-sure 0.05` tells.";
    if (seeds)
        section.intro += fmt::format(
            " Mean and next packing presume that the {} packings show the scatter: with a probability of 5 %, packings of another kind "
            "that make up {:.2g} % of all are absent.",
            seeds->packings, 100.0 * seeds->unseen_share);
    const auto& weighed = k->bed_of_measured_porosity;
    if (weighed) section.intro += intro_of_measured_bed(*weighed);
    const std::string n = seeds ? fmt::format(" (n = {})", seeds->packings) : "";
    section.header = {"quantity", "this packing (n = 1)", "mean of such packings" + n, "next such packing" + n};
    if (weighed) section.header.push_back(fmt::format("the bed of measured porosity {:g}", weighed->measured_porosity));
    for (const results::Quantity& row : results::reported_quantities) {
        const results::Statements* found = statements_about(input, row.name);
        if (found == nullptr) continue;
        section.rows.push_back({row.label, with_interval(found->this_packing, row.format),
                                with_interval(found->mean_of_such_packings, row.format),
                                with_interval(found->next_such_packing, row.format)});
        if (const auto& bed = found->bed_of_measured_porosity; weighed)
            section.rows.back().push_back(bed ? with_interval(bed->statement, row.format) : dash);
    }
    return section;
}

namespace {

std::string standard_uncertainty_text(const Sides& sides) {
    const auto percent = [](double u) {
        return u == 0.0 ? std::string("0") : u < 1e-5 ? std::string("< 0.001 %") : fmt::format("{:.2g} %", 100.0 * u);
    };
    const auto& [below, above] = sides;
    if (below == above) return below == 0.0 ? "< 0.001 %" : percent(below);
    return fmt::format("{} below, {} above", percent(below), percent(above));
}

}  // namespace

namespace {

using Rows = std::vector<uncertainty::BudgetRow>;

void add_budget_picture(const Rows& rows, const Path& folder, ReportSection& section) {
    Table table({"contribution", "percent", "part"});
    for (const auto& row : rows)
        table.add(row.source, 100.0 * row.relative_standard_uncertainty.wider(),
                  row.part == Part::numerical ? 1
                  : row.part == Part::scatter ? 2
                  : row.part == Part::hint    ? 3
                                              : 4);
    table.write(folder / "budget.csv");
    if (draw_plot(folder / "budget.svg", "budget", {{"count", static_cast<double>(rows.size())}},
                  {.width = 620, .height = 90 + 26 * static_cast<int>(rows.size())}))
        section.pictures.emplace_back("budget.svg",
                                      "Contributions to the uncertainty of k: numerical (blue), scatter between packings (orange), "
                                      "uncertain input (red), hint (grey). Those below 0.001 % "
                                      "are drawn at 0.001 %.");
}

}  // namespace

ReportSection budget_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Uncertainty budget of k"};
    if (!input.results.uncertainty) return section;
    const Rows& rows = input.results.uncertainty->budget_of_permeability;
    section.intro =
        "Standard uncertainties u (one standard deviation, not the 95 % of the statements) of k of one packing, below and above k where "
        "they differ. Numerical contributions are in all statements above. An uncertain input, as friction, is in those about the mean and "
        "the next packing. "
        "The scatter between packings is in these two. A hint is in none: it suggests the scatter where only one packing is known, or "
        "shows what half the resolution of an image does to k.";
    section.header = {"contribution", "u(k)/k", "part", "evidence", "from"};
    for (const auto& row : rows)
        section.rows.push_back({row.source, standard_uncertainty_text(row.relative_standard_uncertainty), std::string(name_of(row.part)),
                                std::string(name_of(row.evidence)), with_powers_of_ten(row.origin)});
    if (!rows.empty()) add_budget_picture(rows, folder, section);
    return section;
}

}  // namespace porepack::report
