// Commands of the falling-head test.
#include <fmt/format.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "analysis/falling_head/common_causes.hpp"
#include "analysis/falling_head/level_curves.hpp"
#include "analysis/falling_head/plan_of_test.hpp"
#include "analysis/falling_head/simulation.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/json.hpp"
#include "record/resolved_config.hpp"
#include "stages/case_space.hpp"

namespace porepack::apps {
namespace {

struct SimulateOptions {
    double permeability_m2 = 0.0;
    double inertial_permeability_m = std::numeric_limits<double>::infinity();
};

void simulate(const Common& common, const SimulateOptions& options) {
    const auto config = config_from_flags<FallingHeadConfig>(common.flags);
    if (common.output.empty() && !common.dry_run)
        return print_result(common, simulate_falling_head(options.permeability_m2, options.inertial_permeability_m, config, false).result);
    Json configuration = resolved_config(config);
    configuration["permeability_m2"] = options.permeability_m2;
    configuration["inertial_permeability_m"] = fmt::format("{:g}", options.inertial_permeability_m);
    run_on_files(common,
                 {.stage = "falling-head", .target = common.output, .configuration = configuration, .work = [&](const Path& folder) {
                      return written(simulate_falling_head(options.permeability_m2, options.inertial_permeability_m, config, true), folder);
                  }});
}

void plan(const Common& common, const SimulateOptions& options) {
    const auto config = apps::config_of<TestPlanConfig>(common.flags);
    Flags of_apparatus = common.flags;
    for (const KeyRow& row : key_rows([](ConfigVisitor& v) {
             TestPlanConfig plan;
             describe(v, plan);
         }))
        of_apparatus.erase(row.key);
    const auto apparatus = apps::config_of<FallingHeadConfig>(of_apparatus);
    Json configuration = {{"plan", resolved_config(config)}, {"apparatus", resolved_config(apparatus)}};
    configuration["permeability_m2"] = options.permeability_m2;
    configuration["inertial_permeability_m"] = fmt::format("{:g}", options.inertial_permeability_m);
    run_on_files(common, {.stage = "falling-head-plan",
                          .target = common.output.empty() ? Path("falling_head_plan") : Path(common.output),
                          .configuration = configuration,
                          .work = [&](const Path& folder) {
                              return written(plan_falling_head(options.permeability_m2, options.inertial_permeability_m, apparatus, config),
                                             folder);
                          }});
}

void analyse(const Common& common, const std::vector<std::string>& files) {
    const FallingHeadConfig config = common.input.empty() ? config_from_flags<FallingHeadConfig>(common.flags)
                                                          : case_apparatus(read_case(common.input, "falling_head", common.flags));
    const std::vector<Path> curves(files.begin(), files.end());
    run_on_files(common, {.stage = "falling-head-analysis",
                          .target = common.output.empty() ? Path(".") : Path(common.output),
                          .configuration = resolved_config(config),
                          .inputs = curves,
                          .work = [&](const Path& folder) {
                              std::vector<LevelCurve> levels;
                              for (const Path& curve : curves) levels.push_back(read_level_curve(curve));
                              return written(analyse_level_curves(levels, config), folder);
                          }});
}

struct TwoSamples {
    std::vector<std::string> samples;
    std::vector<double> factors;
};

void compare(const Common& common, const TwoSamples& options) {
    const std::vector<Path> samples(options.samples.begin(), options.samples.end());
    run_on_files(common, {.stage = "common-causes",
                          .target = common.output.empty() ? Path("common_causes") : Path(common.output),
                          .configuration = {{"factors", options.factors}},
                          .inputs = results_of_causes(samples),
                          .work = [&](const Path& folder) { return written(compare_causes(samples, options.factors), folder); }});
}

}  // namespace

void add_falling_head_commands(CommandLine& line) {
    const Common& common = line.common;
    auto head = line.add_group("falling-head", "the falling-head test");

    const auto options = std::make_shared<SimulateOptions>();
    auto simulation = line.add_below(
        head, "simulate",
        "water level over time: Eq. 18 in closed form (times_s), and with the water's inertia, wire screens and noise "
        "(times_full_equation_s); with --output, the curve as CSV too",
        "porepack falling-head simulate --permeability 8.9e-7 --inertial-permeability 3.9e-3 --sample-length 0.12 --start-level "
        "1.6 --levels 1.3,0.7,0.1",
        [&common, options] { simulate(common, *options); });
    simulation.add_option("--permeability", options->permeability_m2, "k").type_name("number [m2]").required();
    simulation.add_option("--inertial-permeability", options->inertial_permeability_m, "k_in; default infinite (Darcy's law alone)")
        .type_name("number [m]");
    line.add_keys(simulation, "falling_head",
                  {"causes", "computed_over_measured", "level_offset_uncertainty_m", "scale_uncertainty", "viscosity_uncertainty",
                   "inertia_coefficient_uncertainty", "inertial_exponent_uncertainty"});

    const auto files = std::make_shared<std::vector<std::string>>();
    auto analysis =
        line.add_below(head, "analyse",
                       "k and k_in from measured water levels (above the upper face of the sample): as in the paper, and by least squares",
                       "porepack falling-head analyse run1.csv run2.csv --case cases/falling_head/tetrapod_053",
                       [&common, files] { analyse(common, *files); });
    analysis.add_option("curves", *files, "CSV files: a header with time_s and level_m (or _ms, _mm, ...), then a line per frame")
        .type_name("path")
        .required();
    analysis.add_option("--case", line.common.input, "case whose [falling_head] describes the apparatus; flags override it")
        .type_name("path");
    line.add_keys(analysis, "falling_head",
                  {"start_level_m", "levels_m", "noise_m", "frames_per_s", "seed", "causes", "computed_over_measured"});

    const auto sample = std::make_shared<SimulateOptions>();
    auto planner = line.add_below(head, "plan", "which test tells k: fluids, sample lengths and windows simulated and analysed",
                                  "porepack falling-head plan --permeability 6.3e-7 --inertial-permeability 4.4e-3 --noise 1e-3 "
                                  "--level-offset-uncertainty 1e-3 --scale-uncertainty 0.002",
                                  [&common, sample] { plan(common, *sample); });
    planner.add_option("--permeability", sample->permeability_m2, "about the k of the sample").type_name("number [m2]").required();
    planner.add_option("--inertial-permeability", sample->inertial_permeability_m, "about its k_in").type_name("number [m]").required();
    line.add_keys(planner, [](ConfigVisitor& v) {
        static TestPlanConfig config;
        describe(v, config);
    });
    line.add_keys(planner, "falling_head", {"levels_m", "seed", "causes", "computed_over_measured"});

    line.add_case(line.add_below(head, "case", "the falling-head stage of a case", "porepack falling-head case cases/quickstart",
                                 [&common] { run_in_case(common, "falling-head", "falling_head"); }));
    auto causes = line.add_below(head, "causes", "effect of each cause on k by the paper's evaluation",
                                 "porepack falling-head causes cases/falling_head/tetrapod_053",
                                 [&common] { run_in_case(common, "causes", "falling_head"); });
    causes.add_option("case", line.common.input, "folder with case.toml, with causes = true in [falling_head]")
        .type_name("path")
        .required();

    const auto two = std::make_shared<TwoSamples>();
    auto both = line.add_below(head, "common-causes", "how often the causes that two tests have in common give both factors at once",
                               "porepack falling-head common-causes cases/falling_head/tetrapod_053 cases/falling_head/tetrapod_087",
                               [&common, two] { compare(common, *two); });
    both.add_option("samples", two->samples, "two cases whose causes have been computed, or their results/causes/result.json")
        .type_name("path")
        .expected(2)
        .required();
    both.add_option("--factors", two->factors, "factors to be explained; default: computed_over_measured of the cases")
        .type_name("2 numbers, with commas")
        .delimiter(',')
        .expected(2);
}

}  // namespace porepack::apps
