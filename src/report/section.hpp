// A section of the report, and how results are looked up. Only for the sources of this room.
#pragma once

#include <fmt/format.h>

#include <utility>

#include "report/report.hpp"

namespace porepack {

struct ReportSection {
    std::string title;
    std::string intro = {};
    std::vector<std::string> header = {};
    std::vector<std::vector<std::string>> rows = {};
    std::vector<std::pair<std::string, std::string>> pictures = {};  ///< file, caption
};

/// A member that may be missing, on a path like "lbm/fine/steps": null then.
[[nodiscard]] const Json& at(const ReportInput& input, const std::string& path);

[[nodiscard]] inline std::string number(const Json& value, const char* format = "{:.4g}") {
    return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : "–";
}

[[nodiscard]] ReportSection inertia_section(const ReportInput& input);
[[nodiscard]] ReportSection falling_head_section(const ReportInput& input);
[[nodiscard]] ReportSection causes_section(const ReportInput& input);
/// Draws or copies their pictures to `folder`.
void add_falling_head_pictures(const ReportInput& input, const Path& folder, ReportSection& inertia, ReportSection& head,
                               ReportSection& causes);

}  // namespace porepack
