#include "study/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/interrupt.hpp"
#include "core/members_json.hpp"
#include "core/owned_names.hpp"
#include "core/table.hpp"
#include "report/page.hpp"
#include "report/plot.hpp"
#include "results/report.hpp"
#include "study/study_beds.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// The keys that a comparison needs, of those of results::ReportedQuantity.
struct Quantity {
    std::string name, unit;
    double value = 0.0;
    std::optional<results::QuantityUncertainty> uncertainty{};
};
template <MembersOf<Quantity> Self, typename Visit>
void visit_members(Self& quantity, const Visit& visit) {
    visit("name", quantity.name);
    visit("unit", quantity.unit);
    visit("value", quantity.value);
    visit("uncertainty", quantity.uncertainty);
}

struct CaseResult {
    std::vector<Quantity> quantities;
};
template <MembersOf<CaseResult> Self, typename Visit>
void visit_members(Self& result, const Visit& visit) {
    visit("quantities", result.quantities);
}

// That of a case, or the folder itself.
Path results_in(const Path& folder) {
    return fs::exists(folder / "result.json") ? folder : folder / "results";
}

std::vector<Quantity> quantities_in(const Path& folder) {
    if (const Path file = results_in(folder) / "result.json"; fs::exists(file)) {
        const Json result = read_json(file);
        if (!result.contains("quantities"))
            throw UserError("this is the result of a stage, not of a case", {.where = file.string(), .fix = "name the folder above it"});
        return from_json_members<CaseResult>(result, file.string()).quantities;
    }
    throw UserError("there is no result.json of a case in " + folder.string(),
                    {.allowed = "folders that porepack run or porepack report has written, or their cases",
                     .fix = "run the case first: porepack run " + folder.string()});
}

// A standard uncertainty alone, as older reports have it, is no interval of 95 %.
ComparedValue value_in(const Quantity& quantity) {
    const auto interval = quantity.uncertainty ? quantity.uncertainty->interval.value_or(std::nullopt) : std::nullopt;
    return interval ? ComparedValue{quantity.value, interval->low, interval->high} : ComparedValue{quantity.value, unknown, unknown};
}

std::string text_of(const ComparedValue& value) {
    if (!std::isfinite(value.value)) return "-";
    return std::isfinite(value.low) ? fmt::format("{:.4g} ({:.4g} to {:.4g})", value.value, value.low, value.high)
                                    : fmt::format("{:.4g}", value.value);
}

std::string bed_page(std::size_t result) {
    return fmt::format("compare_bed_{}.html", result + 1);
}

// The beds of those results that have one and both quantities, each a page of its own.
std::string beds_of(const Comparison& comparison, const Path& folder) {
    const auto row = [&](const char* name) {
        return std::ranges::find_if(comparison.rows, [&](const Comparison::Row& one) { return one.quantity == name; });
    };
    const auto x = row("porosity"), y = row("permeability_lbm");
    std::vector<BedPoint> points;
    for (std::size_t c = 0; c < comparison.names.size(); ++c) {
        const Path results = results_in(comparison.names[c]);
        if (x == comparison.rows.end() || y == comparison.rows.end() || !fs::exists(results / "pack" / "packing.json")) continue;
        if (!std::isfinite(x->values[c].value) || !std::isfinite(y->values[c].value)) continue;
        const std::string page = bed_page(c);
        write_bed(results, folder / page, comparison.names[c]);
        points.push_back({comparison.names[c], page, x->values[c].value, y->values[c].value});
    }
    return choice_of_beds(points, "porosity", "k by lattice Boltzmann, m2", true);
}

void write_page(const Comparison& comparison, const Path& folder, bool drawn) {
    report::Page page{.title = "Comparison",
                      .summary = "In brackets: intervals of 95 %. Of one packing: numerical. Of the mean of seeds: their scatter, too."};
    report::ReportSection table{.title = "Quantities", .header = {"quantity", "unit"}};
    table.header.insert(table.header.end(), comparison.names.begin(), comparison.names.end());
    for (const auto& row : comparison.rows) {
        std::string name = row.quantity;
        std::ranges::replace(name, '_', ' ');
        table.rows.push_back({name, row.unit});
        for (const ComparedValue& value : row.values) table.rows.back().push_back(text_of(value));
    }
    if (drawn) table.pictures.emplace_back("compare.svg", "Relative to the first result, with intervals.");
    page.sections = {table};
    try {
        page.bed = beds_of(comparison, folder);
    } catch (const Error& fault) {
        if (interrupted()) throw;
        // no libjs-three, or results of another version: the numbers are shown without the beds
        page.notes.push_back(fmt::format("No beds: {}", fault.what()));
    }
    write_text(folder / "compare.html", html_page(page, folder));
}

}  // namespace

Comparison compare_results(const std::vector<Path>& folders) {
    Comparison comparison;
    for (const Path& folder : folders) {
        const std::size_t column = comparison.names.size();
        comparison.names.push_back(folder.lexically_normal().string());
        for (const Quantity& quantity : quantities_in(folder)) {
            const std::string& name = quantity.name;
            if (!std::isfinite(quantity.value)) continue;
            auto row = std::find_if(comparison.rows.begin(), comparison.rows.end(), [&](const auto& r) { return r.quantity == name; });
            if (row == comparison.rows.end()) row = comparison.rows.insert(comparison.rows.end(), {name, quantity.unit, {}});
            row->values.resize(column, {unknown, unknown, unknown});
            row->values.push_back(value_in(quantity));
        }
    }
    for (auto& row : comparison.rows) row.values.resize(comparison.names.size(), {unknown, unknown, unknown});
    return comparison;
}

Json to_json(const Comparison& comparison) {
    Json json = {{"results", comparison.names}, {"quantities", Json::array()}};
    for (const auto& row : comparison.rows) {
        Json values = Json::array();
        for (const auto& [value, low, high] : row.values)
            values.push_back({{"value", json_of(value)}, {"interval", std::isfinite(low) ? json_of(Interval{low, high}) : Json(nullptr)}});
        json["quantities"].push_back({{"name", row.quantity}, {"unit", row.unit}, {"values", values}});
    }
    return json;
}

std::string text_of(const Comparison& comparison) {
    std::vector<std::vector<std::string>> lines = {{"quantity", "unit"}};
    lines[0].insert(lines[0].end(), comparison.names.begin(), comparison.names.end());
    for (const auto& row : comparison.rows) {
        lines.push_back({row.quantity, row.unit});
        for (const ComparedValue& value : row.values) lines.back().push_back(text_of(value));
    }
    std::vector<std::size_t> widths(lines[0].size(), 0);
    for (const auto& line : lines)
        for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
    std::string text;
    for (const auto& line : lines) {
        for (std::size_t c = 0; c < line.size(); ++c)
            text += c + 1 < line.size() ? fmt::format("{:<{}}  ", line[c], widths[c]) : line[c] + "\n";
    }
    text +=
        "In brackets: intervals of 95 %. Of one packing: numerical. Of the mean of seeds: their scatter, too. Of paths: of the mean over "
        "them.\n";
    return for_terminal(text);
}

void write_comparison(const Comparison& comparison, const Path& folder) {
    make_folder(folder);
    std::vector<std::string> names = {"compare.csv", "compare.dat", "compare.svg", "compare.gnuplot", "compare.html"};
    for (std::size_t c = 0; c < comparison.names.size(); ++c) names.push_back(bed_page(c));
    OwnedNames(folder).claim(names);
    Table table({"quantity", "unit", "result", "value", "low", "high"});
    report::PlotValues values = {{"count", static_cast<double>(comparison.names.size())}};
    std::string points;
    int places = 0;
    for (const auto& row : comparison.rows) {
        for (std::size_t c = 0; c < row.values.size(); ++c)
            table.add(row.quantity, row.unit, comparison.names[c], row.values[c].value, row.values[c].low, row.values[c].high);
        const double first = row.values.front().value;
        if (!std::isfinite(row.values.front().low) || !(first > 0.0)) continue;
        for (std::size_t c = 0; c < row.values.size(); ++c)
            if (const auto& [value, low, high] = row.values[c]; std::isfinite(value)) {
                const bool known = std::isfinite(low);
                points += fmt::format("{} {} {:.9g} {:.9g} {:.9g} {}\n", c,
                                      places + 0.6 * (static_cast<double>(c) + 0.5) / static_cast<double>(row.values.size()) - 0.3,
                                      value / first, (known ? low : value) / first, (known ? high : value) / first, known ? 1 : 0);
            }
        std::string label = row.quantity;
        std::replace(label.begin(), label.end(), '_', ' ');
        values.emplace_back(fmt::format("label_{}", places + 1), label);
        ++places;
    }
    table.write(folder / "compare.csv");
    if (points.empty()) return write_page(comparison, folder, false);
    write_text(folder / "compare.dat", points);
    values.emplace_back("places", static_cast<double>(places));
    for (std::size_t c = 0; c < comparison.names.size(); ++c) values.emplace_back(fmt::format("title_{}", c + 1), comparison.names[c]);
    const bool drawn = report::draw_plot(folder / "compare.svg", "compare", values, {.width = 760, .height = 420});
    write_page(comparison, folder, drawn);
}

}  // namespace porepack::study
