#include "analysis/falling_head/cause_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/uses.hpp"
#include "core/table.hpp"
#include "falling_head/column.hpp"

namespace porepack::analysis {

const char* evidence_of(const UncertainCause& cause) {
    return cause.judged ? "judged" : "published or computed";
}

namespace {

void add_tables(Files& files, const CauseStudy& study) {
    Table table({"cause", "what", "low", "high", "unit", "factor_low", "factor_high", "evidence", "source"});
    table.digits = 4;
    for (const CauseFactors& found : study.causes)
        table.add(found.cause.name, found.cause.what, found.cause.low, found.cause.high, found.cause.unit, found.at_low, found.at_high,
                  evidence_of(found.cause), found.cause.source);
    files.tables.emplace_back("causes.csv", table);
    Table joint({"drawn", "factor"});
    for (const JointFactors& one : study.joint)
        for (const double factor : one.factors) joint.add(one.what, factor);
    files.tables.emplace_back("joint.csv", joint);
}

// Bars from the factor at one end of the range to that at the other, the longest on top; an end without k reaches the left edge.
void add_tornado(Files& files, const CauseStudy& study, double wanted) {
    std::vector<const CauseFactors*> order;
    for (const CauseFactors& found : study.causes) order.push_back(&found);
    const auto span = [](const CauseFactors* found) {
        const auto of = [](const std::optional<double>& factor) { return std::log(std::max(1e-3, factor.value_or(1e-3))); };
        return std::abs(of(found->at_high) - of(found->at_low));
    };
    std::stable_sort(order.begin(), order.end(), [&](const auto* one, const auto* other) { return span(one) < span(other); });
    Table rows({"# row", "at_low", "at_high", "label"});
    for (const CauseFactors* found : order)
        rows.add(rows.rows(), found->at_low.value_or(0.01), found->at_high.value_or(0.01),
                 fmt::format("{} ({:.2g} to {:.2g}{}{})", found->cause.name, found->cause.low, found->cause.high,
                             found->cause.unit.empty() ? "" : " ", found->cause.unit));
    files.tables.emplace_back("causes.dat", rows);
    files.plots.push_back({"causes.svg",
                           "causes",
                           {{"rows", static_cast<double>(order.size())}, {"wanted", wanted}, {"base", study.evaluation_alone}},
                           {.width = 1000, .height = 110 + 22 * static_cast<int>(order.size()), .font = 11}});
}

// Shares of the draws whose factor is larger, for each set of causes.
void add_joint(Files& files, const CauseStudy& study, double wanted) {
    Table rows({"# factor", "share", "number"});
    report::PlotValues values = {{"wanted", wanted}, {"count", static_cast<double>(study.joint.size())}};
    for (std::size_t j = 0; j < study.joint.size(); ++j) {
        const JointFactors& one = study.joint[j];
        values.emplace_back(fmt::format("title_{}", j + 1), one.what);
        for (std::size_t i = 0; i < one.factors.size(); i += 5)
            rows.add(one.factors[i], static_cast<double>(one.factors.size() - i) / static_cast<double>(one.draws), j + 1);
    }
    files.tables.emplace_back("joint.dat", rows);
    files.plots.push_back({"joint.svg", "joint", values, {.width = 760, .height = 420}});
}

// Change of the water level from Eq. 18 by each effect.
void add_effects(Files& files, const Resistance& sample, const FallingHeadConfig& config) {
    FallingHeadConfig bare = config;
    bare.column_inertia = false;
    bare.screen_opening_m = bare.screen_wire_m = bare.level_offset_m = bare.noise_m = bare.loss_coefficient = 0.0;
    std::vector<std::pair<std::string, FallingHeadConfig>> effects = {{"Eq. 18", bare}};
    FallingHeadConfig inertia = bare, screens = bare, offset = bare;
    inertia.column_inertia = true;
    offset.level_offset_m = 2e-3;
    effects.emplace_back("inertia of the water", inertia);
    if (config.screen_opening_m > 0.0) {
        screens.screen_opening_m = config.screen_opening_m;
        screens.screen_wire_m = config.screen_wire_m;
        effects.emplace_back("wire screens", screens);
    }
    effects.emplace_back("true level + 2 mm", offset);
    std::vector<std::string> header = {"time_s"};
    std::vector<std::vector<double>> levels;
    const LevelCurve times = simulate_curve(sample, inertia);
    for (auto& [name, effect] : effects) {
        levels.push_back(Column(effect).levels(sample, 0.0, config.start_level_m, 0.0, times.time_s));
        header.push_back(name);
    }
    Table table(header);
    table.digits = 8;
    for (std::size_t i = 0; i < times.time_s.size(); ++i) {
        std::vector<std::string> row = {table.field(times.time_s[i])};
        for (const auto& level : levels) row.push_back(table.field(level[i]));
        table.add_row(row);
    }
    files.tables.emplace_back("effects.csv", table);
    files.plots.push_back({"effects.svg", "effects", {{"columns", static_cast<double>(header.size())}}, {.width = 900, .height = 400}});
}

}  // namespace

Files files_of_causes(const CauseStudy& study, const SampleTruth& sample, const FallingHeadConfig& config) {
    Files files;
    add_tables(files, study);
    add_tornado(files, study, config.computed_over_measured);
    add_joint(files, study, config.computed_over_measured);
    add_effects(files, {1.0 / sample.permeability_m2, 1.0 / sample.inertial_permeability_m}, config);
    return files;
}

}  // namespace porepack::analysis
