#include "study/study_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/build.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/owned_names.hpp"
#include "report/page.hpp"
#include "report/plot.hpp"
#include "study/formula.hpp"
#include "study/study_beds.hpp"
#include "study/study_fits.hpp"
#include "study/study_run.hpp"
#include "study/study_table.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
namespace {

std::string text_in(const StudyRow& row, const std::string& column) {
    const auto found = row.find(column);
    return found == row.end() ? std::string() : found->second;
}

// One row of each point, in the order of the points.
std::vector<StudyRow> chosen_rows(const Study& study, RowChoice choice) {
    const std::vector<StudyRow> all = read_rows(study);
    std::vector<StudyRow> rows;
    for (const Point& point : study.points) {
        auto found = std::find_if(all.begin(), all.end(), [&](const StudyRow& row) { return is_current(row, point); });
        if (found == all.end() && choice == RowChoice::with_stale)
            found = std::find_if(all.begin(), all.end(), [&](const StudyRow& row) { return row.at("point") == point.name; });
        if (found != all.end()) rows.push_back(*found);
    }
    return rows.empty() ? rows : with_columns(std::move(rows), study.config);
}

constexpr int curve_points = 300;

// A line of the figure, as values: gnuplot evaluates no text of a user.
struct Curve {
    std::string title, lines;
};

// A range of more than a decade is sampled in equal ratios, so that a curve on a logarithmic axis is as smooth at its lower end.
std::string sampled(const std::function<double(double)>& value, double low, double high) {
    std::string lines;
    for (int i = 0; i < curve_points; ++i) {
        const double part = static_cast<double>(i) / (curve_points - 1);
        const double x = low > 0.0 && high > 10.0 * low ? low * std::pow(high / low, part) : low + (high - low) * part;
        if (const double y = value(x); std::isfinite(y)) lines += fmt::format("{:.9g} {:.9g}\n", x, y);
    }
    return lines;
}

// The published curves of a figure and its fits.
std::vector<Curve> curves_of(const Study& study, const std::vector<StudyRow>& rows, const FigureConfig& figure, double low, double high) {
    std::vector<Curve> curves;
    for (const Json& name : figure.fits) {
        const auto fit =
            std::find_if(study.config.fits.begin(), study.config.fits.end(), [&](const FitConfig& one) { return one.name == name; });
        if (fit == study.config.fits.end())
            throw UserError(fmt::format("there is no fit {}", name.dump()), {.where = "study.toml, [[figure]] " + figure.name});
        if (column_named(rows, fit->x) != column_named(rows, figure.x) || column_named(rows, fit->y) != column_named(rows, figure.y))
            throw UserError(fmt::format("the fit \"{}\" is of other columns than the figure", fit->name),
                            {.where = "study.toml, [[figure]] " + figure.name});
        for (const FittedCurve& curve : fitted_curves(rows, *fit))
            if (curve.value)
                curves.push_back(
                    {curve.group.empty() ? curve.fit : curve.fit + ", " + curve.group, sampled(curve.value, curve.x_low, curve.x_high)});
    }
    for (const Json& entry : figure.curves) {
        const Formula formula(entry.value("formula", std::string()), {"x"}, "study.toml, [[figure]] " + figure.name);
        curves.push_back({entry.value("title", std::string()), sampled([&](double x) { return formula(std::span(&x, 1)); }, low, high)});
    }
    std::erase_if(curves, [](const Curve& curve) { return curve.lines.empty(); });
    return curves;
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

std::pair<double, double> range_of(const std::vector<StudyRow>& rows, const std::string& column) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const StudyRow& row : rows)
        if (const double value = number_in(row, column); std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    return {low, high};
}

std::vector<FittedCurve> all_fits(const Study& study, const std::vector<StudyRow>& rows) {
    std::vector<FittedCurve> all;
    for (const FitConfig& fit : study.config.fits) {
        const std::vector<FittedCurve> some = fitted_curves(rows, fit);
        all.insert(all.end(), some.begin(), some.end());
    }
    return all;
}

ReportSection fits_section(const std::vector<FittedCurve>& curves) {
    ReportSection section{
        .title = "Fits",
        .intro =
            "Least squares. Intervals of 95 %. Residuals of exponential curves and powers are those of ln y, as fractions. "
            "Bias: mean of curve minus points.",
        .header = {"fit", "points", "curve", "coefficients", "bias", "residual", "R²"}};
    for (const FittedCurve& curve : curves) {
        std::string coefficients;
        for (const Coefficient& c : curve.coefficients)
            coefficients += fmt::format("{}{} {:.3g} to {:.3g}", coefficients.empty() ? "" : "; ", c.name, c.interval.low, c.interval.high);
        const auto number = [&](const char* format, double value) {
            return curve.value ? fmt::format(fmt::runtime(format), value) : std::string("–");
        };
        section.rows.push_back({curve.group.empty() ? curve.fit : curve.fit + ", " + curve.group, std::to_string(curve.points), curve.text,
                                coefficients, number("{:.2g}", curve.bias), number("{:.2g}", curve.residual),
                                number("{:.3f}", curve.r_squared)});
    }
    return section;
}

}  // namespace

std::string label_of(const std::string& column) {
    auto [name, unit] = split_unit(column.substr(column.find('.') == std::string::npos ? 0 : column.find('.') + 1));
    std::replace(name.begin(), name.end(), '_', ' ');
    if (unit.ends_with("m2") || unit.ends_with("m3")) unit = unit.substr(0, unit.size() - 1) + (unit.back() == '2' ? "²" : "³");
    return unit.empty() ? name : fmt::format("{} ({})", name, unit);
}

bool draw_figure(const Study& study, const FigureConfig& figure, RowChoice choice) {
    const std::vector<StudyRow> rows = chosen_rows(study, choice);
    if (const std::size_t old = read_rows(study).size(); rows.empty())
        throw UserError(old == 0 ? "no point of the study is done"
                                 : fmt::format("none of the {} rows of study.csv is of these settings and of this version", old),
                        {.fix = fmt::format("porepack study run {}, or porepack study plot --stale {} for the old rows",
                                            study.folder.string(), study.folder.string())});
    const std::string x = column_named(rows, figure.x), y = column_named(rows, figure.y);
    const std::vector<Group> groups = groups_of(rows, x, y, figure);
    const auto [low, high] = range_of(rows, x);
    const std::vector<Curve> curves = curves_of(study, rows, figure, low, high);
    const Path folder = study.folder / "figures";
    make_folder(folder);
    OwnedNames(folder).claim({figure.name + ".dat", figure.name + ".png", figure.name + ".svg", figure.name + ".gnuplot"});
    PlotValues values = {{"data", figure.name + ".dat"},
                         {"x_label", label_of(x)},
                         {"y_label", label_of(y)},
                         {"by_label", figure.by.empty() ? std::string() : label_of(column_named(rows, figure.by))},
                         {"logarithmic", figure.logarithmic ? 1.0 : 0.0},
                         {"logarithmic_x", figure.logarithmic_x ? 1.0 : 0.0},
                         {"groups", static_cast<double>(groups.size())},
                         {"curves", static_cast<double>(curves.size())},
                         {"marks", static_cast<double>(figure.marks.size())}};
    // One data set for each group, curve and mark, in this order. Two blank lines separate data sets, which gnuplot addresses by their
    // index.
    std::string data = "# x, y, low, high\n";
    for (std::size_t i = 0; i < groups.size(); ++i) {
        values.emplace_back(fmt::format("group_{}", i + 1), groups[i].name);
        data += groups[i].lines + "\n\n";
    }
    for (std::size_t i = 0; i < curves.size(); ++i) {
        values.emplace_back(fmt::format("curve_{}", i + 1), curves[i].title);
        data += curves[i].lines + "\n\n";
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

void write_study_page(const Study& study, RowChoice choice, bool beds) {
    OwnedNames(study.folder).claim({"study.html", "fits.csv"});
    Page page;
    page.title = fmt::format("Study {}", fs::absolute(study.folder).lexically_normal().filename().string());
    page.versions = {{"porepack", program_version()}, {"git_hash", git_hash()}};
    Json axes = Json::array();
    for (const std::string& key : study.keys) axes.push_back(key);
    page.configuration = {{"base", study.config.base}, {"up_to", study.config.up_to}, {"axes", axes}};
    ReportSection figures{.title = "Figures"}, points{.title = "Points"};
    for (const FigureConfig& figure : study.config.figures)
        if (draw_figure(study, figure, choice))
            figures.pictures.emplace_back(figure.name + ".svg",
                                          fmt::format("{} against {}. Bars: intervals of 95 %.", label_of(figure.y), label_of(figure.x)));
    const std::vector<FittedCurve> curves = all_fits(study, chosen_rows(study, choice));
    if (!curves.empty()) write_fits(curves, study.folder / "fits.csv");
    std::map<std::string, long> states;
    for (const auto& [point, state, why] : status_of(study)) {
        ++states[state];
        if (state == "failed") page.notes.push_back(fmt::format("{} failed: {}", point, why));
        if (state != "done" && state != "failed") page.notes.push_back(fmt::format("{} is {}.", point, state));
    }
    const std::vector<std::pair<std::string, std::string>> shown = {{"porosity", "porosity"},
                                                                    {"permeability_m2", "k (m²)"},
                                                                    {"permeability_low_m2", "k, low"},
                                                                    {"permeability_high_m2", "k, high"},
                                                                    {"tortuosity_hydraulic", "tortuosity, hydraulic"},
                                                                    {"tortuosity_geometric_paper", "tortuosity, geometric"},
                                                                    {"packings", "packings"}};
    points.intro = choice == RowChoice::current ? "Current rows of study.csv." : "Rows of study.csv; of points that are stale, old rows.";
    points.intro += " Low and high: interval of 95 %.";
    points.header = {"point"};
    for (const auto& [column, title] : shown) points.header.push_back(title);
    for (const StudyRow& row : chosen_rows(study, choice)) {
        points.rows.push_back({row.at("point")});
        for (const auto& [column, title] : shown) {
            const double value = number_in(row, column);
            points.rows.back().push_back(std::isfinite(value) ? fmt::format("{:.4g}", value) : "–");
        }
        const std::string report = fmt::format("points/{}/results/report.html", row.at("point"));
        points.links.push_back(fs::exists(study.folder / report) ? report : "");
    }
    if (beds) {
        const FigureConfig figure =
            study.config.figures.empty() ? FigureConfig{.x = "porosity", .y = "permeability_m2"} : study.config.figures.front();
        const std::vector<StudyRow> rows = chosen_rows(study, choice);
        page.bed = beds_html(study, rows, column_named(rows, figure.x), column_named(rows, figure.y), figure.logarithmic);
        if (page.bed.empty()) page.notes.push_back("No point has a packing: there are no beds to show.");
    }
    for (const auto& [state, count] : states) page.main_numbers.push_back({state, fmt::format("{} of {}", count, study.points.size())});
    page.sections = {figures, fits_section(curves), points};
    write_text(study.folder / "study.html", html_page(page, study.folder / "figures"));
}

}  // namespace porepack::study
