// Commands on whole cases: run, status, pack, report.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "analysis/relax.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/members_json.hpp"
#include "record/resolved_config.hpp"
#include "results/report.hpp"
#include "study/case_pipeline.hpp"
#include "study/compare.hpp"

namespace porepack::apps {
namespace {

void print_main_numbers(const Case& c, const results::Report& report) {
    for (const auto& [label, text] : report.main_numbers) fmt::print("{:<28} {}\n", label, text);
    fmt::print("report: {}\n", for_terminal(std::filesystem::absolute(c.results() / "report.html").lexically_normal().string()));
}

void run_case(const Common& common, const std::string& last) {
    const Case the_case = open_case(common, "packings", common.flags);
    say_files_outside(the_case);
    const Json plan = plan_case(the_case, last, common.dry_run ? slowness() : 1.0);  // finds at once what a later stage would refuse
    if (common.dry_run) return print_result(common, plan);
    const Json result = run_pipeline(case_pipeline(the_case), last);
    if (!last.empty()) return print_stage(common, last, result, the_case.stage_folder(last) / "manifest.json");
    if (common.json) return print_result(common, read_json(the_case.results() / "result.json"));
    print_main_numbers(the_case, from_json_members<results::Report>(result));
}

void print_status(const Common& common) {
    Json json = Json::array();
    for (const StageStatus& entry : status_of(case_pipeline(open_case(common)))) {
        json.push_back({{"stage", entry.name}, {"state", name_of(entry.state)}, {"why", entry.why}, {"wall_time_s", entry.wall_time_s}});
        if (!common.json)
            fmt::print("{:<13} {:<22} {}\n", entry.name, name_of(entry.state),
                       entry.state == StageState::done ? human_time(entry.wall_time_s) : entry.why);
    }
    if (common.json) fmt::print("{}\n", json.dump(2));
}

// Pours a case, or relaxes the grains of a given packing.
void pack(const Common& common, const std::string& from) {
    if (from.empty() && common.input.empty())
        throw UserError("neither a case nor a packing is given", {.where = "pack", .allowed = "pack CASE, or pack --from packing.json"});
    if (from.empty()) return run_in_case(common, "pack", "packing");
    if (!common.input.empty() || !common.set.empty())
        throw UserError("--from takes shape and container from the packing, not from a case",
                        {.where = common.input, .fix = "give one of them"});
    const auto config = config_from_flags<pouring::PackingConfig>(common.flags);
    run_on_files(common, {.stage = "relax",
                          .target = common.output.empty() ? Path("relaxed") : Path(common.output),
                          .configuration = {{"packing", resolved_config(config)}},
                          .inputs = {from},
                          .work = [&](const Path& folder) {
                              return written(analysis::relax_packing(packing::read_packing(from), config), folder);
                          }});
}

void compare(const Common& common, const std::vector<std::string>& folders) {
    const Comparison comparison = compare_results({folders.begin(), folders.end()});
    if (!common.output.empty() && !common.dry_run) write_comparison(comparison, common.output);
    if (common.json) return print_result(common, to_json(comparison));
    fmt::print("{}", text_of(comparison));
}

}  // namespace

// A case of someone else may name any file.
void say_files_outside(const Case& the_case) {
    const Settings& settings = the_case.settings;
    for (const std::string& file : {settings.shape.file, settings.image.file, settings.packing.file}) {
        const Path path = Path(file).lexically_normal();
        if (path.empty() || (!path.is_absolute() && *path.begin() != "..")) continue;
        const Path from = the_case.resolve(file).lexically_normal();
        if (std::filesystem::exists(from))
            log_info("the case reads {}, which lies outside of its folder", from.string());
        else
            log_warning(fmt::format("the case names {}, which does not exist: correct `file`", from.string()));
    }
}

void add_case_commands(CommandLine& line) {
    const Common& common = line.common;
    const auto last = std::make_shared<std::string>();
    auto run = line.add("run", "run all stages of a case that are not done", "porepack run cases/quickstart --until-sure 0.05",
                        [&, last] { run_case(common, *last); });
    line.add_case(run);
    line.add_keys(run, "packings");
    line.add_ranks(run, "processes of MPI for each flow by lattice Boltzmann; default: [parallel] ranks of the case");
    run.add_option("--up-to", *last, "run only this stage and those that it needs").type_name("stage");
    line.add_case(line.add("status", "show which stages of a case are done, stale, failed or missing", "porepack status cases/quickstart",
                           [&] { print_status(common); }));
    const auto from = std::make_shared<std::string>();
    auto pour = line.add("pack", "pour the grains of a case (exact capsules, or LIGGGHTS), or relax given ones",
                         "porepack pack cases/quickstart --seed 7", [&, from] { pack(common, *from); });
    line.add_case(pour);
    pour.option("case").required(false);
    line.add_keys(pour, "packing");
    pour.add_option(
            "--from", *from,
            "no case: the grains of this packing.json, as found in a scan, move until they no longer overlap and rest on each other")
        .type_name("path");
    const auto folders = std::make_shared<std::vector<std::string>>();
    line.add("compare",
             "the main quantities of several results side by side; with --output, compare.csv, compare.svg and compare.html with the beds "
             "to be turned",
             "porepack compare cases/quickstart cases/own_stl --output comparison", [&, folders] { compare(common, *folders); })
        .add_option("results", *folders, "folders of results, or of cases")
        .type_name("path")
        .required();
    auto report = line.add("report", "write the report of a case, running what it needs", "porepack report cases/quickstart",
                           [&] { run_in_case(common, "report", "report"); });
    line.add_case(report);
    line.add_keys(report, "report");
}

}  // namespace porepack::apps
