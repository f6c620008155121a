// Whether the solvers converged, and what the stages cost.
#include <cmath>
#include <string>

#include "core/log.hpp"
#include "core/members_json.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

std::string percent(double value) {
    return std::isfinite(value) ? fmt::format("{:.2g} %", 100.0 * value) : dash;
}

}  // namespace

ReportSection convergence_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Did it converge?"};
    section.header = {"check", "value"};
    const auto add = [&](const char* name, const std::string& value) {
        if (value != dash) section.rows.push_back({name, value});
    };
    if (const auto& lbm = input.results.lbm) {
        add("LBM: iteration error of k", percent(lbm->iteration_error));
        add("LBM: flow rate, maximum difference between layers", percent(lbm->flow_imbalance));
        add("LBM: time steps", number_text(lbm->steps, "{:.0f}"));
        add("LBM: fluid nodes", number_text(lbm->fine.nodes, "{:.0f}"));
        add("LBM: pore cells without flow", number_text(lbm->fine.isolated_cells, "{:.0f}"));
        add("LBM: node updates per second", number_text(lbm->updates_per_second, "{:.3g}"));
        // The data are next to the script, so that names in it are relative: a path may contain any character.
        if (take_file(input, "lbm/history.csv", folder) &&
            draw_plot(folder / "convergence.svg", "convergence", {{"tolerance", lbm->iteration_tolerance}}))
            section.pictures.emplace_back(
                "convergence.svg",
                "Lattice Boltzmann on the finest grid: the run stops when the iteration error is below the tolerance at two checks. It is "
                "unknown at the first checks.");
    }
    if (const auto& foam = input.results.foam) {
        add("OpenFOAM: iterations (finest mesh)", number_text(foam->iterations, "{:.0f}"));
        add("OpenFOAM: cells (finest mesh)", number_text(foam->cells, "{:.0f}"));
        add("OpenFOAM: flow in against flow out", percent(foam->fine.flow_imbalance));
        add("OpenFOAM: meshed / exact pore volume", number_text(foam->fine.mesh_volume_ratio, "{:.4f}"));
    }
    return section;
}

ReportSection cost_section(const ReportInput& input) {
    ReportSection section{.title = "Cost"};
    section.header = {"stage", "wall time", "peak memory", "seed", "processes"};
    double sum = 0.0;
    for (const std::string& stage : input.stages) {
        const auto cost = from_json_members<results::StageCost>(input.manifests.at(stage), stage + "/manifest.json");
        sum += cost.wall_time_s;
        section.rows.push_back({stage, human_time(cost.wall_time_s), human_bytes(cost.peak_memory_bytes), std::to_string(cost.seed),
                                std::to_string(cost.processes)});
    }
    section.rows.push_back({"all", human_time(sum), "", "", ""});
    return section;
}

}  // namespace porepack::report
