// A page of sections with tables and pictures, as HTML and as Markdown.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"
#include "core/interval.hpp"
#include "core/json.hpp"
#include "core/sides.hpp"
#include "results/report.hpp"

namespace porepack::report {

/// Shown where it has rows or pictures.
struct ReportSection {
    std::string title;
    std::string intro = {};
    std::vector<std::string> header = {};
    std::vector<std::vector<std::string>> rows = {};
    std::vector<std::pair<std::string, std::string>> pictures = {};  ///< file, caption
    std::vector<std::string> links = {};                             ///< of the first field of each row; none if empty
};

/// What a reader cites, and how sure it is.
struct Answer {
    std::vector<std::string> sentences = {};                  ///< the first is the answer
    std::vector<std::pair<std::string, double>> shares = {};  ///< of the variance, by what causes it; their sum is 1
    std::vector<std::string> stated = {};                     ///< labels of the main numbers that the sentences state
};

struct Page {
    std::string title;
    std::string summary = {};             ///< what the page is about, before its numbers
    Answer answer = {};                   ///< after the summary
    std::string bed = {};                 ///< HTML (bed_view_html), after that
    std::vector<std::string> notes = {};  ///< shown at the top
    std::vector<results::MainNumber> main_numbers = {};
    std::vector<ReportSection> sections = {};
    core::Json versions = {}, configuration = {};  ///< shown at the end
};

/// Below this, an interval is narrower than half of the last of four digits.
inline constexpr double min_percent_shown = 0.005;
/// Of an interval about a value, in per cent of it: "± 1.2 %", or "(− 6.8 %, + 1.8 %)" where the sides differ in the digits shown;
/// "(exact to these digits)" where it is narrower than those.
[[nodiscard]] std::string percent_text(double value, const core::Interval& interval);

[[nodiscard]] std::string base64(const std::string& bytes);
/// A template with its {{names}} filled, in one pass: inserted text is not searched again.
[[nodiscard]] std::string filled(const std::string& page, const std::map<std::string, std::string>& values);

/// Pictures of the sections are in `folder`; the page embeds them.
[[nodiscard]] std::string html_page(const Page& page, const core::Path& folder);
/// The same page; its pictures are in report/.
[[nodiscard]] std::string markdown_page(const Page& page);

}  // namespace porepack::report
