// The report as one HTML page.
#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "core/data_file.hpp"
#include "core/escape.hpp"
#include "report/page.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

// A command in it is not broken into lines.
std::string sentence_html(const std::string& sentence) {
    static const std::regex command("porepack run --until-sure [0-9.]*[0-9]");
    return std::regex_replace(for_html(sentence), command, "<code>$&</code>");
}

// The answer first, then a bar of what its uncertainty is from.
std::string answer_html(const Answer& answer) {
    if (answer.sentences.empty()) return "";
    std::string html = "<div class=\"answer\"><p><strong>" + for_html(answer.sentences.front()) + "</strong></p>\n";
    for (std::size_t i = 1; i < answer.sentences.size(); ++i) html += "<p>" + sentence_html(answer.sentences[i]) + "</p>\n";
    if (!answer.shares.empty()) {
        std::string bar, legend;
        for (const auto& [name, share] : answer.shares) {
            bar += fmt::format("<i style=\"flex:{:.4f}\"></i>", std::max(share, 0.004));
            const std::string percent = share < 0.01 ? "< 1" : share > 0.99 && share < 1.0 ? "> 99" : fmt::format("{:.0f}", 100.0 * share);
            legend += fmt::format("<span><i></i>{} {} %</span>", for_html(name), for_html(percent));
        }
        html += "<p>The uncertainty of one packing's k is, by variance, from</p><div class=\"bar\" aria-hidden=\"true\">" + bar +
                "</div><div class=\"legend\">" + legend + "</div>\n";
    }
    return html + "</div>\n";
}

std::string anchor_of(const ReportSection& section) {
    std::string anchor;
    for (const char c : section.title)
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return anchor;
}

std::string contents_html(const std::vector<ReportSection>& sections) {
    std::string html;
    for (const ReportSection& section : sections)
        if (!section.rows.empty() || !section.pictures.empty())
            html += fmt::format("<a href=\"#{}\">{}</a>\n", anchor_of(section), for_html(section.title));
    return "<nav aria-label=\"contents\">" + html + "</nav>\n";
}

// An SVG picture as a part of the page: its ids are its own, and it has a name for those who do not see it.
std::string inline_svg(const std::string& text, const std::string& stem, const std::string& caption) {
    std::string svg = text.substr(text.find("<svg"));
    svg = std::regex_replace(svg, std::regex("(\\bid=[\"'])"), "$1" + stem + "-");
    svg = std::regex_replace(svg, std::regex("(href=[\"']#|url\\(#)"), "$1" + stem + "-");
    svg.insert(4, " role=\"img\" aria-label=\"" + for_html(caption) + "\"");
    return svg;
}

// Of a file that gnuplot reads: blanks between values become commas.
std::string as_csv(const std::string& text) {
    std::string csv;
    bool in_text = false, between = false, comment = false;
    for (const char c : text) {
        if (csv.empty() || csv.back() == '\n') comment = c == '#';
        if (c == '"') in_text = !in_text;
        if ((c == ' ' || c == '\t') && !in_text && !comment) {
            between = true;
            continue;
        }
        if (between && c != '\n' && !csv.empty() && csv.back() != '\n') csv += ',';
        between = false;
        csv += c;
    }
    return csv;
}

// The files that the script beside a plot reads, to be kept.
std::string data_links(const Path& picture) {
    Path script = picture;
    script.replace_extension(".gnuplot");
    if (!std::filesystem::exists(script)) return "";
    std::string links;
    const std::string text = read_text(script);
    std::set<std::string> seen;
    static const std::regex name("'([A-Za-z0-9_.-]+)\\.(csv|dat)'");
    for (std::sregex_iterator found(text.begin(), text.end(), name), end; found != end; ++found) {
        const std::string stem = found->str(1), file = stem + "." + found->str(2);
        if (!seen.insert(file).second || !std::filesystem::exists(picture.parent_path() / file)) continue;
        const std::string data = read_text(picture.parent_path() / file);
        links += fmt::format(" <a download=\"{0}.csv\" href=\"data:text/csv;base64,{1}\">{0}.csv</a>", for_html(stem),
                             base64(found->str(2) == "csv" ? data : as_csv(data)));
    }
    return links;
}

std::string section_html(const ReportSection& section, const Path& folder) {
    std::string html = "<h2 id=\"" + anchor_of(section) + "\">" + for_html(section.title) + "</h2>\n";
    if (!section.intro.empty()) html += "<p>" + for_html(section.intro) + "</p>\n";
    html += "<div class=\"wide\"><table><tr>";
    for (const auto& head : section.header) html += "<th>" + for_html(head) + "</th>";
    html += "</tr>\n";
    for (std::size_t i = 0; i < section.rows.size(); ++i) {
        html += "<tr>";
        const std::string link = i < section.links.size() ? section.links[i] : "";
        for (const auto& cell : section.rows[i])
            html += link.empty() || &cell != &section.rows[i].front()
                        ? "<td>" + for_html(cell) + "</td>"
                        : fmt::format("<td><a href=\"{}\">{}</a></td>", for_html(link), for_html(cell));
        html += "</tr>\n";
    }
    html += "</table></div>\n";
    for (const auto& [file, caption] : section.pictures) {
        const std::string bytes = read_text(folder / file);
        const std::string picture = file.ends_with(".svg")
                                        ? inline_svg(bytes, Path(file).stem().string(), caption)
                                        : "<img alt=\"" + for_html(caption) + "\" src=\"data:image/png;base64," + base64(bytes) + "\">";
        html += "<figure>" + picture + "<figcaption>" + for_html(caption) + data_links(folder / file) + "</figcaption></figure>\n";
    }
    return html;
}

}  // namespace

std::string base64(const std::string& bytes) {
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(size));
    return text;
}

std::string filled(const std::string& page, const std::map<std::string, std::string>& values) {
    std::string text;
    std::size_t at = 0;
    for (std::size_t open = 0; (open = page.find("{{", at)) != std::string::npos;) {
        const std::size_t close = page.find("}}", open);
        text += page.substr(at, open - at) + values.at(page.substr(open + 2, close - open - 2));
        at = close + 2;
    }
    return text + page.substr(at);
}

std::string html_page(const Page& page, const Path& folder) {
    std::string notes, numbers, tables;
    for (const auto& note : page.notes) notes += "<p class=\"note\">" + for_html(note) + "</p>\n";
    for (const auto& [label, text] : page.main_numbers) {
        if (std::count(page.answer.stated.begin(), page.answer.stated.end(), label) > 0) continue;
        numbers += "<div>" + for_html(label) + "<b>" + for_html(text) + "</b></div>";
    }
    for (const auto& section : page.sections)
        if (!section.rows.empty() || !section.pictures.empty()) tables += section_html(section, folder);
    return filled(read_text(data_file("templates/report.html")),
                  {{"title", for_html(page.title)},
                   {"summary", page.summary.empty() ? "" : "<p>" + for_html(page.summary) + "</p>\n"},
                   {"answer", answer_html(page.answer)},
                   {"bed", page.bed},
                   {"contents", contents_html(page.sections)},
                   {"notes", notes},
                   {"main_numbers", numbers},
                   {"sections", tables},
                   {"script", read_text(data_file("templates/page.js"))},
                   {"versions", for_html(page.versions.dump(2))},
                   {"configuration", for_html(page.configuration.dump(2))}});
}

}  // namespace porepack::report
