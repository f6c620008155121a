// The sections of the report, one function each, and how they write numbers. Only for the sources of this folder.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

#include "core/files.hpp"
#include "core/interval.hpp"
#include "report/page.hpp"
#include "report/report.hpp"

namespace porepack::report {

/// Each draws its pictures into `folder`. A section without rows and pictures is not shown.
[[nodiscard]] ReportSection uncertainty_section(const ReportInput& input);
[[nodiscard]] ReportSection budget_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection permeability_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection packing_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection tortuosity_section(const ReportInput& input);
[[nodiscard]] ReportSection descriptors_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection inertia_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection falling_head_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection causes_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection convergence_section(const ReportInput& input, const core::Path& folder);
[[nodiscard]] ReportSection cost_section(const ReportInput& input);

/// k in one sentence; empty where there is none.
[[nodiscard]] Answer answer_of(const ReportInput& input);
/// What was poured into what, and which part of it was solved.
[[nodiscard]] std::string scene_text(const ReportInput& input);

inline constexpr const char* dash = "–";  ///< of what is not known

/// "1.2e-06 m²" as "1.2 × 10⁻⁶ m²", with spaces at which a line does not break.
[[nodiscard]] std::string with_powers_of_ten(const std::string& text);
/// A dash for no value, or one that is not finite.
[[nodiscard]] std::string number_text(std::optional<double> value, const char* format = "{:.4g}");
/// "low to high", or "none".
[[nodiscard]] std::string interval_text(const std::optional<core::Interval>& interval);
/// Relative difference in per cent, or a dash.
[[nodiscard]] std::string difference(std::optional<double> value, std::optional<double> reference);

/// Of 95 %, of the mean of k over packings: the statement's, else that of the seeds alone.
[[nodiscard]] std::optional<core::Interval> interval_of_mean_permeability(const ReportInput& input);
/// Of 95 %, about a value with a standard uncertainty of the computation.
[[nodiscard]] std::optional<core::Interval> two_standard_uncertainties(double value, double standard_uncertainty);
/// Of 95 %, by Student's t, of the mean over `number` paths or starting points.
[[nodiscard]] std::optional<core::Interval> interval_of_path_mean(double mean, double standard_error, long number);
/// One statement about a quantity as text: sure_text(input, "porosity", &results::Statements::this_packing). A dash where there is none.
[[nodiscard]] std::string sure_text(const ReportInput& input, const std::string& quantity, results::Statement results::Statements::*which);
/// The same of the bed whose porosity was measured.
[[nodiscard]] std::string measured_bed_text(const ReportInput& input, const std::string& quantity);

/// What the main number with this statement about `name` is called: "k, next packing".
[[nodiscard]] std::string statement_label(const ReportInput& input, const std::string& name,
                                          results::Statement results::Statements::*which);

/// The paper's text about a quantity of this grain ("porosity", "tortuosity"); empty where it states nothing.
[[nodiscard]] std::string paper_number(const ReportInput& input, const std::string& quantity);
/// Of the whole bed, or of the whole image.
[[nodiscard]] std::optional<double> bed_porosity_of(const results::CaseResults& results);

/// The hydraulic gradient at which inertia makes K 5 % smaller, from computed flows or Ergun's correlation. None where neither is known.
struct GradientLimit {
    double gradient;
    std::string from;  ///< "as computed", "by Ergun's correlation"
};
[[nodiscard]] std::optional<GradientLimit> gradient_limit(const ReportInput& input);

/// Copies a file of the results to `folder`, if it exists.
bool take_file(const ReportInput& input, const core::Path& file, const core::Path& folder);

}  // namespace porepack::report
