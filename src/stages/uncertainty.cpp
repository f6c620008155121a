// How sure the case's numbers are.
#include "analysis/uncertainty.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/table.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
using uncertainty::SectionScatter;

std::optional<SectionScatter> section_scatter_of(const Case& c) {
    const Path file = c.stage_folder("lbm") / "gradient.csv";
    if (!std::filesystem::exists(file)) return std::nullopt;
    std::vector<double> gradient;
    double low = 0.0, high = 0.0;
    for (const auto& row : read_table(file)) {
        if (gradient.empty()) low = row.at(0);
        high = row.at(1);
        gradient.push_back(row.at(2));
    }
    return uncertainty::section_scatter(gradient, high - low, case_pore_space(c).equivalent_diameter_m);
}

Stage make_uncertainty_stage(const Case& c, const std::vector<std::string>& stages) {
    std::vector<std::string> needs;
    for (const std::string& stage : stages)
        for (const char* used : {"pack", "voxelise", "lbm", "foam", "seeds", "tortuosity"})
            if (stage == used) needs.push_back(stage);
    const auto run = [c, needs](const Path&) {
        const auto needed = [&](const std::string& stage) { return std::find(needs.begin(), needs.end(), stage) != needs.end(); };
        const results::CaseResults results = results::read_results(c.results(), needed);  // an optional stage may have failed
        analysis::BedOfCase bed{.packing = c.settings.packing, .section = section_scatter_of(c)};
        if (results.pack && !results.pack->overlap_allowed.value_or(false)) bed.space = case_pore_space(c);
        return analysis::state_uncertainty(results, bed);
    };
    return {.name = "uncertainty",
            .needs = needs,
            .configuration = deciding_keys(c, {"container"}, {}, true),
            .run = run,
            .result_version = results::Uncertainty::version};
}

}  // namespace porepack::stages
