// The report of a case.
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/json.hpp"
#include "core/log.hpp"
#include "permeability/fluid.hpp"
#include "record/engine_versions.hpp"
#include "report/paraview.hpp"
#include "report/report.hpp"
#include "report/slip.hpp"
#include "stages/case_space.hpp"
#include "stages/report_pictures.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace fs = std::filesystem;
namespace {

std::string title_of(const Case& c) {
    if (!c.settings.report.title.empty()) return c.settings.report.title;
    const Path folder = fs::absolute(c.folder).lexically_normal();
    return folder.filename().empty() ? folder.parent_path().filename().string() : folder.filename().string();
}

results::Report run_report(const Case& c, const std::vector<std::string>& shown, const Path& folder) {
    ReportInput input{.title = title_of(c), .configuration = c.settings.resolved_tables()};
    for (const std::string& stage : shown) {
        if (!fs::exists(c.stage_folder(stage) / "result.json")) {
            const std::string failed = stage + ".failed";
            if (fs::exists(c.results() / failed))
                input.notes.push_back(fmt::format("The stage {} failed; its results are missing here. See results/{}.", stage, failed));
            continue;
        }
        input.stages.push_back(stage);
        input.documents[stage] = read_json(c.stage_folder(stage) / "result.json");
        input.manifests[stage] = read_json(c.stage_folder(stage) / "manifest.json");
    }
    input.results = results::read_results(c.results(), [&](const std::string& stage) { return input.documents.contains(stage); });
    const ReportConfig& config = c.settings.report;
    input.fluid = permeability::fluid_at(config.fluid, config.temperature_C);
    input.fluid_text = fmt::format("{} at {:g} °C", name_of(config.fluid), config.temperature_C);
    input.versions = record::engine_versions();
    input.stage_folders = c.results();
    if (config.pictures && !c.from_image() && !draw_packing(c, input.results, folder))
        input.notes.push_back("No picture of the packing: rendering failed, see results/report/log.picture.");
    if (config.pictures && has_packing(c)) input.bed = bed_to_turn(c, input.results);
    if (const auto note = slip_note(input, config)) {
        input.notes.push_back(*note);
        log_warning(*note);
    }
    report::write_paraview_script(folder / "view.py", c.results());
    return write_report(input, folder);
}

}  // namespace

Stage make_report_stage(const Case& c, const std::vector<std::string>& needs, const std::vector<std::string>& shown) {
    return {
        .name = "report",
        .needs = needs,
        .configuration = c.settings.resolved_tables({"report"}),
        .outputs = {"report.html", "report.md", "view.py"},
        .run = [c, shown](const Path& folder) { return run_report(c, shown, folder); },
        .result_version = results::Report::version,
        .published = {{"view.py", "view.py"}, {"report.html", "report.html"}, {"report.md", "report.md"}, {"result.json", "merged.json"}}};
}

}  // namespace porepack::stages
