// Studies: one case with several values of some keys.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/machine.hpp"
#include "core/members_json.hpp"
#include "study/study_export.hpp"
#include "study/study_figures.hpp"
#include "study/study_run.hpp"

namespace porepack::apps {
namespace {

// One line per point; `last`: the member shown at its end.
template <typename Point>
void print_points(const std::vector<Point>& points, std::string Point::*last) {
    std::size_t width = 5;
    for (const Point& point : points) width = std::max(width, point.point.size());
    for (const Point& point : points) fmt::print("{:<{}}  {:<12} {}\n", point.point, width, point.state, point.*last);
}

void print_plan(const Common& common, const Study& study, const StudyPlan& plan) {
    if (common.json) return print_result(common, plan);
    print_points(plan.points, &PlannedPoint::expected);
    fmt::print("all, {} at once: {}; free memory {}\n", plan.at_once, plan.expected, plan.memory_available);
    if (plan.max_time) fmt::print("{}\n", *plan.max_time);
    if (!plan.left_out.empty()) fmt::print("not run, by up_to = \"{}\": {}\n", study.config.up_to, fmt::join(plan.left_out, ", "));
}

void run(const Common& common, const StudyRunOptions& options) {
    const Study the_study = read_study(common.input);
    if (common.dry_run) return print_plan(common, the_study, plan_study(the_study, options));
    const StudyRunResult result = run_study(the_study, options);
    if (common.json)
        print_result(common, result);
    else
        fmt::print("{} points: {} done now, {} before, {} failed, {} run by another process, {} not begun\ntable: {}\n", result.points,
                   result.done.size(), result.current_before, result.failed.size(), result.elsewhere.size(), result.not_begun,
                   result.table);
    if (!result.failed.empty())
        throw NumericalError(fmt::format("{} of {} points failed; the first, {}: {}", result.failed.size(), result.points,
                                         result.failed[0].point, result.failed[0].error),
                             {.fix = fmt::format("porepack study status {} lists them; points that fail are run again by the next call",
                                                 the_study.folder.string())});
}

void print_status(const Common& common) {
    const std::vector<PointStatus> list = status_of(read_study(common.input));
    if (common.json) return print_result(common, json_of(list));
    print_points(list, &PointStatus::why);
}

void plot(const Common& common, const FigureConfig& figure, RowChoice choice, bool beds) {
    const Study the_study = read_study(common.input);
    if (figure.x.empty() && figure.y.empty()) {
        write_study_page(the_study, choice, beds);
        fmt::print("written: {}\n", for_terminal((the_study.folder / "study.html").lexically_normal().string()));
        return;
    }
    if (beds) throw UserError("beds are shown in study.html, not in one figure", {.where = "--beds", .fix = "leave out --x and --y"});
    if (figure.x.empty() || figure.y.empty())
        throw UserError("a figure needs --x and --y", {.fix = "or neither, which draws the figures of study.toml"});
    FigureConfig named = figure;
    if (named.name.empty()) named.name = as_plain_name(fmt::format("{}_against_{}", figure.y, figure.x));
    require_plain_name(named.name, "the name of a figure", "--name");
    if (draw_figure(the_study, named, choice))
        for (const char* kind : {".svg", ".png"})
            fmt::print("written: {}\n", for_terminal((the_study.folder / "figures" / (named.name + kind)).lexically_normal().string()));
}

void write_workflow(const Common& common, bool snakemake) {
    if (!snakemake) throw UserError("no format is chosen", {.allowed = "--snakemake"});
    fmt::print("written: {}\n", for_terminal(write_snakefile(read_study(common.input)).lexically_normal().string()));
}

}  // namespace

void add_study_commands(CommandLine& line) {
    const Common& common = line.common;
    auto study = line.add_group("study", "many cases from one: run them, list them, draw them");
    const auto add = [&](const std::string& name, const std::string& help, const std::string& example,
                         const std::function<void()>& action) {
        auto command = line.add_below(study, name, help, example, action);
        command.add_option("study", line.common.input, "folder with study.toml").type_name("path").required();
        return command;
    };
    const auto options = std::make_shared<StudyRunOptions>();
    auto run_command =
        add("run", "run the points that have no current row in study.csv, several at once",
            "porepack study run cases/paper_study_quick --points 1-3 --max-time 3600", [&common, options] { run(common, *options); });
    run_command.add_option("--points", options->points, "only these: names, or numbers from 1 (\"2,5-7\")").type_name("list");
    run_command.add_option("--max-time", options->max_time_s, "seconds after which no point begins").type_name("number [s]").not_negative();
    add("status", "the state of each point", "porepack study status cases/paper_study_quick", [&common] { print_status(common); });
    const auto figure = std::make_shared<FigureConfig>();
    const auto stale = std::make_shared<bool>(false), beds = std::make_shared<bool>(false);
    auto plot_command =
        add("plot", "one figure of the columns of study.csv; without --x and --y all figures of study.toml, and study.html",
            "porepack study plot cases/paper_study_quick --x sphericity --y permeability_m2 --by shape --logarithmic",
            [&common, figure, stale, beds] { plot(common, *figure, *stale ? RowChoice::with_stale : RowChoice::current, *beds); });
    plot_command.add_option("--x", figure->x, "column of study.csv").type_name("column");
    plot_command.add_option("--y", figure->y, "column of study.csv; its interval is drawn too").type_name("column");
    plot_command.add_option("--by", figure->by, "column that tells groups apart").type_name("column");
    plot_command.add_option("--name", figure->name, "of the files in figures/").type_name("text");
    plot_command.add_flag("--stale", *stale, "also the rows of other settings or of another version, of points without a current row");
    plot_command.add_flag("--beds", *beds, "study.html shows the bed of a point that is chosen, on a page points/NAME/view.html");
    plot_command.add_flag("--logarithmic", figure->logarithmic, "logarithmic axis of y");
    const auto snakemake = std::make_shared<bool>(false);
    add("export", "the study for a workflow engine", "porepack study export cases/paper_study_quick --snakemake", [&common, snakemake] {
        write_workflow(common, *snakemake);
    }).add_flag("--snakemake", *snakemake, "write a Snakefile (Snakemake 7)");
}

}  // namespace porepack::apps
