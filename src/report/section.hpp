// The sections of the report, and how results are looked up. Only for the sources of this folder.
#pragma once

#include <fmt/format.h>

#include <optional>

#include "report/page.hpp"

namespace porepack::report {

/// A member that may be missing, on a path like "lbm/fine/steps": null then.
[[nodiscard]] const core::Json& result_at(const ReportInput& input, const std::string& path);

/// "1.2e-06 m²" as "1.2 × 10⁻⁶ m²", with spaces at which a line does not break.
[[nodiscard]] std::string with_powers_of_ten(const std::string& text);

[[nodiscard]] inline std::string number_text(const core::Json& value, const char* format = "{:.4g}") {
    return value.is_number() ? with_powers_of_ten(fmt::format(fmt::runtime(format), value.get<double>())) : "–";
}

/// "low to high", or "none".
[[nodiscard]] std::string interval_text(const core::Json& interval);
/// Of 95 %, of the mean of k over packings: the statement's, else that of the seeds alone; null without them.
[[nodiscard]] const core::Json& interval_of_mean_permeability(const ReportInput& input);
/// Of 95 %, about a value with a standard uncertainty of the computation.
[[nodiscard]] std::optional<core::Interval> two_standard_uncertainties(const core::Json& value, const core::Json& standard_uncertainty);
/// Of 95 %, by Student's t, of the mean over paths or starting points: "geometric_paper_exact", "geometric_paper_pixels", "shortest_path".
[[nodiscard]] std::optional<core::Interval> interval_of_path_mean(const ReportInput& input, const std::string& kind);
/// Relative difference in per cent, or a dash.
[[nodiscard]] std::string difference(const core::Json& value, const core::Json& reference);

[[nodiscard]] ReportSection uncertainty_section(const ReportInput& input);
[[nodiscard]] ReportSection budget_section(const ReportInput& input);
/// One statement of the uncertainty stage: "this_packing", "mean_of_such_packings", "next_such_packing" or
/// "bed_of_measured_porosity".
[[nodiscard]] std::string sure_text(const ReportInput& input, const std::string& quantity, const char* which);
[[nodiscard]] ReportSection permeability_section(const ReportInput& input);
[[nodiscard]] ReportSection packing_section(const ReportInput& input);
[[nodiscard]] ReportSection descriptors_section(const ReportInput& input);
void add_descriptor_pictures(const ReportInput& input, const core::Path& folder, ReportSection& section);
[[nodiscard]] ReportSection tortuosity_section(const ReportInput& input);
[[nodiscard]] ReportSection convergence_section(const ReportInput& input);
[[nodiscard]] ReportSection cost_section(const ReportInput& input);
[[nodiscard]] ReportSection inertia_section(const ReportInput& input);
[[nodiscard]] ReportSection falling_head_section(const ReportInput& input);
[[nodiscard]] ReportSection causes_section(const ReportInput& input);

/// What was poured into what, and which part of it was solved.
[[nodiscard]] std::string scene_text(const ReportInput& input);
/// The hydraulic gradient at which inertia makes K 5 % smaller, from computed flows or Ergun's correlation. None where neither is known.
struct GradientLimit {
    double gradient;
    std::string from;  ///< "as computed", "by Ergun's correlation"
};
[[nodiscard]] std::optional<GradientLimit> gradient_limit(const ReportInput& input);

/// The same page as html_page().
[[nodiscard]] std::string markdown_page(const ReportInput& input, const std::vector<ReportSection>& sections,
                                        const core::Json& main_numbers);

void add_budget_picture(const ReportInput& input, const core::Path& folder, ReportSection& section);
/// Draws or copies their pictures to `folder`.
void add_falling_head_pictures(const ReportInput& input, const core::Path& folder, ReportSection& inertia, ReportSection& head,
                               ReportSection& causes);

}  // namespace porepack::report
