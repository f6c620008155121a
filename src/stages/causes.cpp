// Causes of the difference between measured and computed permeabilities: each with its factor, in tables and figures.
#include "falling_head/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/resolved_config.hpp"
#include "core/table.hpp"
#include "falling_head/column.hpp"
#include "lbm/paper_scheme.hpp"
#include "lbm/wall_effect.hpp"
#include "report/plot.hpp"
#include "stages/falling_head.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace packing;
using namespace pore_space;
using namespace lbm;
using namespace falling_head;
using namespace report;
using namespace pipeline;
namespace {

constexpr const char* evidence_of(const UncertainCause& cause) {
    return cause.judged ? "judged" : "published or computed";
}

results::Cause result_of(const CauseFactors& found) {
    return {.cause = found.cause.name,
            .what = found.cause.what,
            .range = {found.cause.low, found.cause.high},
            .unit = found.cause.unit,
            .factors = {found.at_low, found.at_high},
            .source = found.cause.source,
            .evidence = evidence_of(found.cause)};
}

results::JointCauses result_of(const JointFactors& joint) {
    return {.what = joint.what,
            .range_factor = joint.range_factor,
            .draws = joint.draws,
            .without_k = joint.without_k,
            .median = joint.median,
            .interval = {joint.low, joint.high},
            .reaches = joint.reaches};
}

void write_causes(const Path& folder, const CauseStudy& study) {
    Table table({"cause", "what", "low", "high", "unit", "factor_low", "factor_high", "evidence", "source"});
    table.digits = 4;
    for (const CauseFactors& found : study.causes)
        table.add(found.cause.name, found.cause.what, found.cause.low, found.cause.high, found.cause.unit, found.at_low, found.at_high,
                  evidence_of(found.cause), found.cause.source);
    table.write(folder / "causes.csv");
    Table joint({"drawn", "factor"});
    for (const JointFactors& one : study.joint)
        for (const double factor : one.factors) joint.add(one.what, factor);
    joint.write(folder / "joint.csv");
}

// Bars from the factor at one end of the range to that at the other, the longest on top; an end without k reaches the left edge.
void draw_tornado(const Path& folder, const CauseStudy& study, double wanted) {
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
    rows.write(folder / "causes.dat");
    draw_plot(folder / "causes.svg", "causes",
              {{"rows", static_cast<double>(order.size())}, {"wanted", wanted}, {"base", study.evaluation_alone}},
              {.width = 1000, .height = 110 + 22 * static_cast<int>(order.size()), .font = 11});
}

// Shares of the draws whose factor is larger, for each set of causes.
void draw_joint(const Path& folder, const CauseStudy& study, double wanted) {
    Table rows({"# factor", "share", "number"});
    report::PlotValues values = {{"wanted", wanted}, {"count", static_cast<double>(study.joint.size())}};
    for (std::size_t j = 0; j < study.joint.size(); ++j) {
        const JointFactors& one = study.joint[j];
        values.emplace_back(fmt::format("title_{}", j + 1), one.what);
        for (std::size_t i = 0; i < one.factors.size(); i += 5)
            rows.add(one.factors[i], static_cast<double>(one.factors.size() - i) / static_cast<double>(one.draws), j + 1);
    }
    rows.write(folder / "joint.dat");
    draw_plot(folder / "joint.svg", "joint", values, {.width = 760, .height = 420});
}

// Change of the water level from Eq. 18 by each effect.
void draw_effects(const Path& folder, const Resistance& sample, const FallingHeadConfig& config) {
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
    table.write(folder / "effects.csv");
    draw_plot(folder / "effects.svg", "effects", {{"columns", static_cast<double>(header.size())}}, {.width = 900, .height = 400});
}

// Porosities of layers of `height` metres from the floor up.
std::vector<double> porosity_layers(const PoreSpace& space, double sample_length_m, double height) {
    const auto count = static_cast<std::size_t>(std::max(2L, std::lround(sample_length_m / height)));
    const double layer = sample_length_m / static_cast<double>(count);
    std::vector<double> layers;
    for (std::size_t i = 0; i < count; ++i)
        layers.push_back(space.with_section({layer * static_cast<double>(i), layer * static_cast<double>(i + 1)}).porosity(4000).value);
    return layers;
}

// What would change the computed k, not the measured one: the paper's scheme, and a computation without the wall.
results::ComputationEffects effects_on_the_computation(const PoreSpace& space, double porosity, double grain_m) {
    log_info("causes: the paper's lattice Boltzmann scheme, and the wall");
    const double middle = 0.5 * (space.section.z0 + space.section.z1), half = std::min(1.5 * grain_m, 0.5 * space.section.length());
    return {.paper_scheme_over_porepack = paper_scheme_ratio(space.grain_size_m, 1.0 - porosity),
            .core_over_tube = core_over_tube_permeability(space.with_section({middle - half, middle + half}), grain_m)};
}

// k, k_in and what else is known of the flow.
struct Flows {
    double permeability_m2, inertial_permeability_m, largest_reynolds;
    std::optional<double> quasi_steady_inertia;
};

results::Causes run_causes(const PoreSpace& space, const Flows& flows, const FallingHeadConfig& config, const Path& folder) {
    if (space.container.kind != Container::Kind::cylinder || !space.packing)
        throw UserError("the causes are those of a packing in a tube", {.where = "[falling_head] causes", .fix = "causes = false"});
    if (space.bed_top_m < config.sample_length_m)
        throw UserError(fmt::format("the bed is {:g} m high, the sample {:g} m", space.bed_top_m, config.sample_length_m),
                        {.where = "sample_length_m", .fix = "pour more grains, or shorten the sample"});
    const double grain = grain_means(*space.packing).equivalent_diameter_m, central = space.porosity().value;
    const std::vector<double> layers = porosity_layers(space, config.sample_length_m, 0.5 * grain);
    const ProfileFactors ends = profile_factors(layers, central);
    const ProfileFactors dense = profile_factors({std::max(0.1, central - 0.1)}, central);
    const double share = std::min(1.0, grain / config.sample_length_m);
    log_info("causes: simulated tests, evaluated as in the paper");
    const SampleTruth sample{.permeability_m2 = flows.permeability_m2,
                             .inertial_permeability_m = flows.inertial_permeability_m,
                             .porosity = central,
                             .ends_viscous = ends.viscous,
                             .ends_inertial = ends.inertial,
                             .aligned_viscous = 1.0 + share * (dense.viscous - 1.0),
                             .aligned_inertial = 1.0 + share * (dense.inertial - 1.0),
                             .tube_diameter_m = space.container.diameter_m,
                             .grain_diameter_m = grain,
                             .largest_reynolds = flows.largest_reynolds,
                             .quasi_steady_inertia = flows.quasi_steady_inertia};
    const CauseStudy study = study_causes(sample, config, config.computed_over_measured);
    const double nu = config.kinematic_viscosity_m2_per_s;
    const auto reynolds = [&](double length) {
        return std::array{study.speed_top_m_per_s * length / nu, study.speed_bottom_m_per_s * length / nu};
    };
    const double wanted = config.computed_over_measured;
    results::Causes result{.permeability_m2 = flows.permeability_m2,
                           .inertial_permeability_m = flows.inertial_permeability_m,
                           .porosity_central = central,
                           .inertia_coefficient = inertia_coefficient(config),
                           .porosity_layers = layers,
                           .viscous_share_of_head = study.viscous_share,
                           .reynolds = {reynolds(grain), reynolds(space.container.diameter_m)},
                           .evaluation_alone = study.evaluation_alone,
                           .darcy_alone = study.darcy_alone,
                           .to_explain = wanted > 0.0 ? std::optional(wanted) : std::nullopt,
                           .sample = sample,
                           .apparatus = resolved_config(config),
                           .computation = effects_on_the_computation(space, central, grain)};
    for (const CauseFactors& found : study.causes) result.causes.push_back(result_of(found));
    for (const JointFactors& joint : study.joint) result.joint.push_back(result_of(joint));
    write_causes(folder, study);
    draw_tornado(folder, study, wanted);
    draw_joint(folder, study, wanted);
    draw_effects(folder, {1.0 / flows.permeability_m2, 1.0 / flows.inertial_permeability_m}, config);
    return result;
}

Flows flows_of(const Case& c, double inertial_permeability_m) {
    const auto lbm = c.result<results::Lbm>();
    Flows flows{.permeability_m2 = lbm.permeability.m2,
                .inertial_permeability_m = inertial_permeability_m,
                .largest_reynolds = 1.0,
                .quasi_steady_inertia = lbm.inertia_coefficient_quasi_steady};
    if (c.settings.forchheimer.enabled) flows.largest_reynolds = c.result<results::Forchheimer>().lbm.grids.back().flows.back().reynolds;
    return flows;
}

}  // namespace

Stage make_causes_stage(const Case& c) {
    return {.name = "causes",
            .needs = falling_head_needs(c),
            .configuration = deciding_keys(c, {"container", "falling_head"}, {}, true),
            .outputs = {"causes.csv", "joint.csv"},
            .run =
                [c](const Path& folder) {
                    const InertialPermeability inertial = inertial_permeability(c, c.result<results::Voxelise>().porosity);
                    results::Causes result =
                        run_causes(case_pore_space(c).section_only(), flows_of(c, inertial.value_m), apparatus_of(c), folder);
                    result.inertial_permeability_from = inertial.from;
                    return result;
                },
            .expect = [] { return Expectation{.text = "about 8500 simulated tests and three coarse flows", .wall_time_s = 60.0}; }};
}

}  // namespace porepack::stages
