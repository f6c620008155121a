// Causes of the difference between measured and computed permeabilities: each with its factor, in tables and figures.
#include "falling_head/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "falling_head/column.hpp"
#include "lbm/paper_scheme.hpp"
#include "lbm/wall_effect.hpp"
#include "report/plot.hpp"
#include "stages/falling_head.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace packing;
using namespace converters;
using namespace lbm;
using namespace falling_head;
using namespace report;
using namespace pipeline;
namespace {

Json cause_json(const Cause& cause) {
    return {{"cause", cause.name},
            {"what", cause.what},
            {"factor", json_of(cause.factor)},
            {"range", cause.factor ? Json({cause.low, cause.high}) : Json(nullptr)},
            {"note", cause.note}};
}

void write_causes(const Path& file, const std::vector<Cause>& causes) {
    Table table({"cause", "what", "factor", "low", "high", "note"});
    table.digits = 4;
    for (const Cause& cause : causes) {
        const auto known = [&](double value) { return cause.factor ? std::optional(value) : std::nullopt; };
        table.add(cause.name, cause.what, cause.factor, known(cause.low), known(cause.high), cause.note);
    }
    table.write(file);
}

void draw_causes(const Path& folder, const std::vector<Cause>& causes, double wanted) {
    Table rows({"# row", "factor", "low", "high", "label"});
    for (auto cause = causes.rbegin(); cause != causes.rend(); ++cause)
        if (cause->factor) rows.add(rows.rows(), *cause->factor, cause->low, cause->high, cause->name + ": " + cause->what);
    rows.write(folder / "causes.dat");
    const auto count = static_cast<double>(rows.rows());
    draw_plot(folder / "causes.svg", "causes", {{"rows", count}, {"wanted", wanted}},
              {.width = 1200, .height = 90 + 22 * static_cast<int>(rows.rows()), .font = 11});
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

// The last two causes would change the computed k: the paper's scheme, and a computation without the wall.
std::vector<Cause> causes_of_the_computation(const PoreSpace& space, double porosity, double grain_m) {
    log_info("causes: the paper's lattice Boltzmann scheme, and the wall");
    const double scheme = paper_scheme_ratio(space.grain_size_m, 1.0 - porosity);
    const double middle = 0.5 * (space.section.z0 + space.section.z1), half = std::min(1.5 * grain_m, 0.5 * space.section.length());
    const double core = core_over_tube_permeability(space.with_section({middle - half, middle + half}), grain_m);
    return {
        {.name = "the paper's LBM scheme",
         .what = fmt::format("its k / k by PorePack: spheres as wide as the capsules, {:.0f} voxels", space.grain_size_m / paper_voxel_m),
         .factor = scheme,
         .low = scheme,
         .high = scheme},
        {.name = "the wall",
         .what = "k of the core / k of the tube, for a computation without the wall",
         .factor = core,
         .low = core,
         .high = core}};
}

Json run_causes(const PoreSpace& space, double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                const Path& folder) {
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
    CauseStudy study = study_causes({.permeability_m2 = permeability_m2,
                                     .inertial_permeability_m = inertial_permeability_m,
                                     .porosity = central,
                                     .ends_viscous = ends.viscous,
                                     .ends_inertial = ends.inertial,
                                     .aligned_viscous = 1.0 + share * (dense.viscous - 1.0),
                                     .aligned_inertial = 1.0 + share * (dense.inertial - 1.0)},
                                    config, config.computed_over_measured);
    for (const Cause& cause : causes_of_the_computation(space, central, grain)) study.causes.push_back(cause);
    Json json = {{"permeability_m2", permeability_m2},
                 {"inertial_permeability_m", inertial_permeability_m},
                 {"porosity_central", central},
                 {"inertia_coefficient", inertia_coefficient(config)},
                 {"porosity_layers", layers},
                 {"viscous_share_of_head", study.viscous_share},
                 {"to_explain", config.computed_over_measured > 0.0 ? Json(config.computed_over_measured) : Json(nullptr)},
                 {"factor_is", "k true / k by the paper's evaluation; for the last two causes their effect on k computed"},
                 {"causes", Json::array()},
                 {"together", Json::array()}};
    keep_old_name(json, "sample_inertia", "inertia_coefficient");
    for (const Cause& cause : study.causes) json["causes"].push_back(cause_json(cause));
    for (const Cause& cause : study.together) json["together"].push_back(cause_json(cause));
    json["level_offset_that_explains_alone_m"] = json_of(study.explaining_offset_m);
    json["level_offset_that_explains_with_all_m"] = json_of(study.explaining_offset_with_all_m);
    std::vector<Cause> all = study.causes;
    all.insert(all.end(), study.together.begin(), study.together.end());
    write_causes(folder / "causes.csv", all);
    draw_causes(folder, all, config.computed_over_measured);
    draw_effects(folder, {1.0 / permeability_m2, 1.0 / inertial_permeability_m}, config);
    return json;
}

}  // namespace

Stage make_causes_stage(const Case& c) {
    return {.name = "causes",
            .needs = falling_head_needs(c),
            .configuration = deciding_keys(c, {"container", "falling_head"}, {}, true),
            .outputs = {"causes.csv"},
            .run =
                [c](const Path& folder) {
                    const InertialPermeability inertial = inertial_permeability(c, c.result_of("voxelise").at("porosity").get<double>());
                    Json json = run_causes(case_pore_space(c).section_only(), c.result_of("lbm").at("permeability_m2").get<double>(),
                                           inertial.value_m, apparatus_of(c), folder);
                    json["inertial_permeability_from"] = inertial.from;
                    return json;
                },
            .expect = [] { return Expectation{.text = "about 900 simulated tests and three coarse flows", .wall_time_s = 60.0}; }};
}

}  // namespace porepack::stages
