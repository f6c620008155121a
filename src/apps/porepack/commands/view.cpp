// The bed in three dimensions, as a page for a browser.
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <memory>

#include "analysis/bed_view.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/error.hpp"
#include "core/process.hpp"
#include "packing/packing.hpp"
#include "report/paraview.hpp"
#include "results/geometry.hpp"

namespace porepack::apps {
namespace {

bool has_display() {
    return isatty(STDOUT_FILENO) != 0 && (std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr);
}

// Without waiting: what it starts stays.
void start(const std::array<std::string, 2>& command) {
    if (!find_program(command[0]) || fork() != 0) return;
    setsid();
    execlp(command[0].c_str(), command[0].c_str(), command[1].c_str(), nullptr);
    _exit(127);
}

void view_in_paraview(const Common& common, bool no_open) {
    if (!is_case(common.input))
        throw UserError("ParaView opens the results of a case", {.where = common.input, .fix = "open its .stl, .vti and .vtp files there"});
    const Path folder = read_case(common.input).results(), script = common.output.empty() ? folder / "view.py" : Path(common.output);
    if (!std::filesystem::exists(folder))
        throw UserError("the case has no results yet", {.where = common.input, .fix = "porepack run " + common.input});
    if (!common.dry_run) report::write_paraview_script(script, folder);
    if (!common.dry_run && !no_open && has_display()) start({"paraview", "--script=" + std::filesystem::absolute(script).string()});
    print_result(common, {{"script", script.string()}, {"open", "paraview --script=" + script.string()}});
}

void view(const Common& common, bool no_open) {
    const bool of_case = is_case(common.input);
    const Case the_case = of_case ? read_case(common.input) : Case();
    const Path packing_file = of_case ? the_case.stage_folder("pack") / "packing.json" : Path(common.input),
               folder = of_case ? the_case.results() : packing_file.parent_path(),
               page = common.output.empty() ? folder / "view.html" : Path(common.output);
    if (of_case && !std::filesystem::exists(packing_file))
        throw UserError("the case has no packing yet", {.where = common.input, .fix = "porepack pack " + common.input});
    if (!of_case && !is_packing(common.input))
        throw UserError("neither a case nor a packing", {.where = common.input, .allowed = "a folder with case.toml, packing.json[.gz]"});
    const packing::Packing packing = packing::read_packing(packing_file);
    if (common.dry_run) return print_result(common, {{"page", page.string()}, {"grains", packing.bodies.size()}, {"expected", "seconds"}});
    std::optional<Interval> section;
    if (of_case && std::filesystem::exists(the_case.stage_folder("voxelise") / "result.json"))
        section = the_case.result<results::Voxelise>().section_m;
    report::BedView bed = analysis::bed_view_of(packing, section);
    if (of_case) analysis::add_flow(bed, the_case.stage_folder("lbm") / "flow.vti");
    const Path whole = std::filesystem::absolute(of_case ? the_case.folder : packing_file).lexically_normal();
    report::write_bed_page(page, (of_case && whole.filename().empty() ? whole.parent_path() : whole).filename().string(), bed);
    if (!no_open && has_display()) start({"xdg-open", std::filesystem::absolute(page).string()});
    print_result(common, {{"page", page.string()}});
}

}  // namespace

void add_view_command(CommandLine& line) {
    const auto no_open = std::make_shared<bool>(false), paraview = std::make_shared<bool>(false);
    auto command =
        line.add("view", "a page on which the bed can be turned, cut and coloured, opened in the browser", "porepack view cases/quickstart",
                 [&line, no_open, paraview] { (*paraview ? view_in_paraview : view)(line.common, *no_open); });
    command.add_option("input", line.common.input, "a case with a packing, or packing.json[.gz]").type_name("path").required();
    command.add_flag("--no-open", *no_open, "write the page (view.html, or --output) only");
    command.add_flag("--paraview", *paraview,
                     "instead a script (results/view.py) that opens all results of a case in ParaView, and start it");
}

}  // namespace porepack::apps
