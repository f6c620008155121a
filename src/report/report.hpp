// One page per case: results, uncertainty and cost.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/json.hpp"
#include "permeability/fluid.hpp"
#include "report/bed_view.hpp"
#include "results/report.hpp"
#include "results/results.hpp"

namespace porepack::report {

struct ReportInput {
    std::string title;
    core::Json configuration = core::Json::object();
    results::CaseResults results = {};
    std::vector<std::string> stages = {};              ///< that have run, in the order of the case
    std::map<std::string, core::Json> documents = {};  ///< result.json by stage
    std::map<std::string, core::Json> manifests = {};  ///< by stage
    core::Json versions = {};
    permeability::Fluid fluid = {};       ///< of the hydraulic conductivity
    std::string fluid_text = {};          ///< "water at 20 °C"
    core::Path stage_folders = {};        ///< results/: histories and flow fields are read from here
    std::optional<BedView> bed = {};      ///< that can be turned
    std::vector<std::string> notes = {};  ///< shown at the top
};

/// Every main number with unit, method, uncertainty or null, converged or not, cost.
[[nodiscard]] std::vector<results::ReportedQuantity> quantities(const ReportInput& input);

/// Writes report.html (self-contained), report.md and merged.json, with the pictures next to them. packing.png is used
/// when it is in `folder`.
results::Report write_report(const ReportInput& input, const core::Path& folder);

/// The slice y = 0 (or the middle) through the speed of flow.vti with a colour bar and axes: speed.png in `folder`, with its data and
/// script. False without gnuplot.
bool draw_speed_slice(const core::Path& flow_vti, const core::Path& folder);

}  // namespace porepack::report
