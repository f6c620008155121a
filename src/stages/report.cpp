// The report of a case.
#include "report/report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/log.hpp"
#include "permeability/fluid.hpp"
#include "stages/stages.hpp"
#include "core/json.hpp"

namespace porepack::stages {
using namespace core;
using namespace packing;
using namespace report;
using namespace pipeline;
namespace fs = std::filesystem;
namespace {

std::string title_of(const Case& c) {
    if (!c.settings.report.title.empty()) return c.settings.report.title;
    const Path folder = fs::absolute(c.folder).lexically_normal();
    return folder.filename().empty() ? folder.parent_path().filename().string() : folder.filename().string();
}

// False when rendering failed.
bool draw_packing(const Case& c, const results::CaseResults& results, const Path& folder) {
    const Container container = case_container(c);
    const auto bed = results::bed_of(results);
    // The empty part above the bed is not shown.
    const double shown = std::min(container.height(), 1.15 * (bed ? bed->bed_height_m : container.height()));
    std::vector<std::string> more;
    if (container.kind == Container::Kind::cylinder)
        more = {"--container", fmt::format("cylinder:{:.9g},{:.9g}", container.diameter_m, shown)};
    return draw_picture(c.stage_folder("stl") / "solid.stl", folder / "packing.png", more);
}

// A gas in narrow pores: the molecules slip on the walls.
void add_slip_note(ReportInput& input, const ReportConfig& config) {
    if (!input.results.lbm) return;
    const double k = input.results.lbm->permeability.m2, eps = input.results.lbm->porosity;
    const auto knudsen = permeability::knudsen_number(config.fluid, config.temperature_C, k, eps);
    if (!knudsen || *knudsen <= permeability::largest_knudsen_number) return;
    input.notes.push_back(fmt::format(
        "{}: the mean free path of its molecules is {:.2g} times the pore size (sqrt(32 k/porosity) = {:.2g} m). The k of this report is "
        "that of a liquid. Slip on the walls makes k of this gas about {:.2g} % larger, if the pores are like straight tubes; above a "
        "ratio of "
        "0.1 this is a rough estimate.",
        input.fluid_text, *knudsen, std::sqrt(32.0 * k / eps), 800.0 * *knudsen));
    log_warning(input.notes.back());
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
    input.versions = engine_versions();
    input.stage_folders = c.results();
    if (config.pictures && !c.from_image() && !draw_packing(c, input.results, folder))
        input.notes.push_back("No picture of the packing: rendering failed, see results/report/log.picture.");
    add_slip_note(input, config);
    return write_report(input, folder);
}

}  // namespace

Stage make_report_stage(const Case& c, const std::vector<std::string>& needs, const std::vector<std::string>& shown) {
    return {.name = "report",
            .needs = needs,
            .configuration = c.settings.resolved_tables({"report"}),
            .outputs = {"report.html", "report.md"},
            .run = [c, shown](const Path& folder) { return run_report(c, shown, folder); },
            .result_version = 3,
            .published = {{"report.html", "report.html"}, {"report.md", "report.md"}, {"result.json", "merged.json"}}};
}

}  // namespace porepack::stages
