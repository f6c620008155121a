// A page of sections with tables and pictures.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/sides.hpp"
#include "report/report.hpp"

namespace porepack::report {

struct ReportSection {
    std::string title;
    std::string intro = {};
    std::vector<std::string> header = {};
    std::vector<std::vector<std::string>> rows = {};
    std::vector<std::pair<std::string, std::string>> pictures = {};  ///< file, caption
    std::vector<std::string> links = {};                             ///< of the first field of each row; none if empty
};

/// Below this, an interval is narrower than half of the last of four digits.
inline constexpr double smallest_percent_shown = 0.005;
/// Of an interval about a value, in per cent of it: "± 1.2 %", or "(− 6.8 %, + 1.8 %)" where the sides differ in the digits shown;
/// "(exact to these digits)" where it is narrower than those.
[[nodiscard]] std::string percent_text(double value, const core::Interval& interval);

/// HTML. Pictures of the sections are in `folder`; the page embeds them. `main_numbers`: a list of {label, text}.
[[nodiscard]] std::string html_page(const ReportInput& input, const std::vector<ReportSection>& sections, const core::Json& main_numbers,
                                    const core::Path& folder);

}  // namespace porepack::report
