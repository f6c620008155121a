#include "study/study_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/build.hpp"
#include "core/error.hpp"
#include "report/page.hpp"
#include "report/plot.hpp"
#include "study/study_run.hpp"
#include "study/study_table.hpp"

namespace porepack::study {
using namespace core;
using namespace report;
namespace fs = std::filesystem;
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

double number_in(const StudyRow& row, const std::string& column) {
    const auto found = row.find(column);
    if (found == row.end() || found->second.empty()) return not_a_number;
    char* end = nullptr;
    const double value = std::strtod(found->second.c_str(), &end);
    if (*end != '\0')
        throw UserError(fmt::format("column `{}` is not a column of numbers", column), {.allowed = "numbers: " + found->second});
    return value;
}

std::string text_in(const StudyRow& row, const std::string& column) {
    const auto found = row.find(column);
    return found == row.end() ? std::string() : found->second;
}

// "permeability_m2" -> "permeability (m²)".
std::string label_of(const std::string& column) {
    auto [name, unit] = split_unit(column.substr(column.find('.') == std::string::npos ? 0 : column.find('.') + 1));
    std::replace(name.begin(), name.end(), '_', ' ');
    if (unit.ends_with("m2") || unit.ends_with("m3")) unit = unit.substr(0, unit.size() - 1) + (unit.back() == '2' ? "²" : "³");
    return unit.empty() ? name : fmt::format("{} ({})", name, unit);
}

std::vector<StudyRow> current_rows(const Study& study) {
    std::vector<StudyRow> rows = read_rows(study);
    std::erase_if(rows, [&](const StudyRow& row) {
        return std::none_of(study.points.begin(), study.points.end(), [&](const Point& point) { return is_current(row, point); });
    });
    return rows;
}

// gnuplot evaluates it, and gnuplot can run commands: only arithmetic and functions of one argument.
std::string formula_of(const Json& curve) {
    std::string formula = curve.value("formula", std::string());
    static const std::vector<std::string> known = {"exp", "log", "log10", "sqrt", "x", "e", "E"};
    std::string word;
    for (const char c : formula + " ") {
        if (std::isalpha(static_cast<unsigned char>(c)) != 0 || (!word.empty() && std::isdigit(static_cast<unsigned char>(c)) != 0)) {
            word += c;
            continue;
        }
        const bool exponent =
            word.size() > 1 && (word[0] == 'e' || word[0] == 'E') && word.find_first_not_of("0123456789", 1) == std::string::npos;
        if ((!word.empty() && !exponent && std::find(known.begin(), known.end(), word) == known.end()) ||
            (std::isdigit(static_cast<unsigned char>(c)) == 0 && std::string_view("+-*/(). ").find(c) == std::string_view::npos))
            throw UserError(fmt::format("the formula \"{}\" is not possible", formula),
                            {.where = "study.toml, [[figure]] curves", .allowed = "x, numbers, + - * / **, exp, log, log10, sqrt"});
        word.clear();
    }
    if (formula.empty()) throw UserError("a curve needs a formula", {.where = "study.toml, [[figure]] curves"});
    return formula;
}

struct Group {
    std::string name, lines;
};

// x and y: names of columns.
std::vector<Group> groups_of(const std::vector<StudyRow>& rows, const std::string& x, const std::string& y, const FigureConfig& figure) {
    const std::string by = figure.by.empty() ? "" : column_named(rows, figure.by);
    std::vector<Group> groups;
    for (const StudyRow& row : rows) {
        const double at = number_in(row, x), value = number_in(row, y);
        if (!std::isfinite(at) || !std::isfinite(value)) continue;
        double low = number_in(row, with_suffix(y, "low")), high = number_in(row, with_suffix(y, "high"));
        if (!std::isfinite(low) || !std::isfinite(high)) low = high = value;
        if (figure.logarithmic) low = std::max(low, 0.1 * value);  // the bar leaves the figure
        const std::string name = by.empty() ? label_of(y) : text_in(row, by);
        auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& one) { return one.name == name; });
        if (group == groups.end()) group = groups.insert(groups.end(), {name, {}});
        group->lines += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", at, value, low, high);
    }
    if (groups.empty()) throw UserError(fmt::format("no point has both {} and {}", x, y));
    return groups;
}

}  // namespace

bool draw_figure(const Study& study, const FigureConfig& figure) {
    const std::vector<StudyRow> rows = current_rows(study);
    if (rows.empty()) throw UserError("no point of the study is done", {.fix = "porepack study run " + study.folder.string()});
    const std::string x = column_named(rows, figure.x), y = column_named(rows, figure.y);
    const std::vector<Group> groups = groups_of(rows, x, y, figure);
    const Path folder = study.folder / "figures";
    make_folder(folder);
    PlotValues values = {{"data", figure.name + ".dat"},
                         {"x_label", label_of(x)},
                         {"y_label", label_of(y)},
                         {"logarithmic", figure.logarithmic ? 1.0 : 0.0},
                         {"groups", static_cast<double>(groups.size())},
                         {"curves", static_cast<double>(figure.curves.size())},
                         {"marks", static_cast<double>(figure.marks.size())}};
    std::string data = "# x, y, low, high\n";
    for (std::size_t i = 0; i < groups.size(); ++i) {
        values.emplace_back(fmt::format("group_{}", i + 1), groups[i].name);
        data += groups[i].lines + "\n\n";
    }
    for (std::size_t i = 0; i < figure.curves.size(); ++i) {
        values.emplace_back(fmt::format("curve_{}", i + 1), figure.curves[i].value("title", std::string()));
        values.emplace_back(fmt::format("formula_{}", i + 1), formula_of(figure.curves[i]));
    }
    for (std::size_t i = 0; i < figure.marks.size(); ++i) {
        const Json& mark = figure.marks[i];
        if (!mark.contains("x") || !mark.contains("y")) throw UserError("a mark needs x and y", {.where = "study.toml, [[figure]] marks"});
        values.emplace_back(fmt::format("mark_{}", i + 1), mark.value("title", std::string()));
        data += fmt::format("{:.9g} {:.9g}\n\n\n", mark["x"].get<double>(), mark["y"].get<double>());
    }
    write_text(folder / (figure.name + ".dat"), data);
    return draw_plot(folder / (figure.name + ".png"), "study", values, {.width = 620, .height = 380}) &&
           draw_plot(folder / (figure.name + ".svg"), "study", values, {.width = 620, .height = 380});
}

void write_study_page(const Study& study) {
    ReportInput page;
    page.title = fmt::format("Study {}", fs::absolute(study.folder).lexically_normal().filename().string());
    page.versions = {{"porepack", program_version()}, {"git_hash", git_hash()}};
    Json axes = Json::array();
    for (const std::string& key : study.keys) axes.push_back(key);
    page.configuration = {{"base", study.config.base}, {"up_to", study.config.up_to}, {"axes", axes}};
    ReportSection figures{.title = "Figures"}, points{.title = "Points"};
    for (const FigureConfig& figure : study.config.figures)
        if (draw_figure(study, figure))
            figures.pictures.emplace_back(figure.name + ".svg",
                                          fmt::format("{} against {}. Bars: intervals of 95 %.", label_of(figure.y), label_of(figure.x)));
    std::map<std::string, long> states;
    for (const Json& entry : status_of(study)) {
        const auto state = entry["state"].get<std::string>();
        ++states[state];
        if (state == "failed")
            page.notes.push_back(fmt::format("{} failed: {}", entry["point"].get<std::string>(), entry["why"].get<std::string>()));
        if (state != "done" && state != "failed") page.notes.push_back(fmt::format("{} is {}.", entry["point"].get<std::string>(), state));
    }
    const std::vector<std::pair<std::string, std::string>> shown = {{"porosity", "porosity"},
                                                                    {"permeability_m2", "k (m²)"},
                                                                    {"permeability_low_m2", "k, low"},
                                                                    {"permeability_high_m2", "k, high"},
                                                                    {"tortuosity_hydraulic", "tortuosity, hydraulic"},
                                                                    {"tortuosity_geometric_paper", "tortuosity, geometric"},
                                                                    {"packings", "packings"}};
    points.intro = "Current rows of study.csv. Low and high: interval of 95 %.";
    points.header = {"point"};
    for (const auto& [column, title] : shown) points.header.push_back(title);
    for (const StudyRow& row : current_rows(study)) {
        points.rows.push_back({row.at("point")});
        for (const auto& [column, title] : shown) {
            const double value = number_in(row, column);
            points.rows.back().push_back(std::isfinite(value) ? fmt::format("{:.4g}", value) : "–");
        }
        const std::string report = fmt::format("points/{}/results/report.html", row.at("point"));
        points.links.push_back(fs::exists(study.folder / report) ? report : "");
    }
    Json numbers = Json::array();
    for (const auto& [state, count] : states)
        numbers.push_back({{"label", state}, {"text", fmt::format("{} of {}", count, study.points.size())}});
    write_text(study.folder / "study.html", html_page(page, {figures, points}, numbers, study.folder / "figures"));
}

}  // namespace porepack::study
