#include "study/study_beds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "analysis/bed_view.hpp"
#include "core/data_file.hpp"
#include "core/escape.hpp"
#include "core/files.hpp"
#include "report/page.hpp"
#include "results/geometry.hpp"
#include "results/read.hpp"
#include "study/study_figures.hpp"
#include "study/study_fits.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
namespace {

std::string number(double value) {
    return fmt::format("{:.3g}", value);
}

// The points between two axes; each is a button.
std::string plot_of(const std::vector<BedPoint>& dots, const std::string& x_label, const std::string& y_label, bool logarithmic) {
    constexpr double left = 70.0, top = 12.0, width = 380.0, height = 250.0;
    const auto scaled = [&](double value) { return logarithmic ? std::log10(value) : value; };
    const auto [x0, x1] = std::minmax_element(dots.begin(), dots.end(), [](const BedPoint& p, const BedPoint& q) { return p.x < q.x; });
    const auto [y0, y1] = std::minmax_element(dots.begin(), dots.end(), [](const BedPoint& p, const BedPoint& q) { return p.y < q.y; });
    const auto place = [](double value, double low, double high) { return high > low ? (value - low) / (high - low) : 0.5; };
    std::string svg = fmt::format(
        "<svg viewBox=\"0 0 480 320\" role=\"group\" aria-label=\"{} against {}: choose a bed\">\n"
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"currentColor\" opacity=\".4\"/>\n",
        for_html(y_label), for_html(x_label), left - 12, top - 4, width + 24, height + 12);
    const auto text = [&](double at_x, double at_y, const char* anchor, const std::string& words) {
        svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n", at_x, at_y, anchor, for_html(words));
    };
    text(left, top + height + 26, "middle", number(x0->x));
    text(left + width, top + height + 26, "middle", number(x1->x));
    text(left + width / 2, top + height + 44, "middle", x_label);
    text(left - 16, top + height + 4, "end", number(y0->y));
    text(left - 16, top + 8, "end", number(y1->y));
    text(left + 4, top + 14, "start", y_label + (logarithmic ? ", logarithmic" : ""));
    for (const BedPoint& dot : dots)
        svg += fmt::format(
            "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7\" tabindex=\"0\" role=\"button\" data-point=\"{}\"><title>{}: {}, "
            "{}</title></circle>\n",
            left + width * place(dot.x, x0->x, x1->x), top + height * (1.0 - place(scaled(dot.y), scaled(y0->y), scaled(y1->y))),
            for_html(dot.name), for_html(dot.name), number(dot.x), number(dot.y));
    return svg + "</svg>";
}

}  // namespace

void write_bed(const Path& results, const Path& page, const std::string& title) {
    std::optional<Interval> section;
    if (fs::exists(results / "lbm" / "result.json")) section = results::read_result<results::Lbm>(results).section_m;
    report::BedView bed = analysis::bed_view_of(packing::read_packing(results / "pack" / "packing.json"), section);
    analysis::add_flow(bed, results / "lbm" / "flow.vti");
    report::write_bed_page(page, title, bed);
}

std::string choice_of_beds(const std::vector<BedPoint>& points, const std::string& x_label, const std::string& y_label, bool logarithmic) {
    if (points.empty()) return "";
    std::string options;
    for (const BedPoint& point : points)
        options += fmt::format("<option data-page=\"{}\">{}</option>\n", for_html(point.page), for_html(point.name));
    const bool positive = std::all_of(points.begin(), points.end(), [](const BedPoint& point) { return point.y > 0.0; });
    return report::filled(read_text(data_file("templates/study_beds.html")),
                          {{"plot", plot_of(points, x_label, y_label, logarithmic && positive)},
                           {"options", options},
                           {"first", for_html(points.front().page)}});
}

std::string beds_html(const Study& study, const std::vector<StudyRow>& rows, const std::string& x, const std::string& y, bool logarithmic) {
    std::vector<BedPoint> dots;
    for (const StudyRow& row : rows) {
        const std::string point = row.at("point"), page = fmt::format("points/{}/view.html", point);
        const Path results = study.folder / "points" / point / "results";
        const double at_x = number_in(row, x), at_y = number_in(row, y);
        if (!fs::exists(results / "pack" / "packing.json") || !std::isfinite(at_x) || !std::isfinite(at_y)) continue;
        write_bed(results, study.folder / page, fmt::format("Bed of the point {}", point));
        dots.push_back({point, page, at_x, at_y});
    }
    return choice_of_beds(dots, label_of(x), label_of(y), logarithmic);
}

}  // namespace porepack::study
