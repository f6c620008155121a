// What opens in a browser, or in ParaView: the bed in three dimensions, and the documents.
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <memory>

#include "analysis/bed_view.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
#include "imaging/volume.hpp"
#include "packing/packing.hpp"
#include "report/paraview.hpp"
#include "results/fit.hpp"
#include "results/geometry.hpp"
#include "results/pack.hpp"

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

// What a page shows, and where it stands.
struct Viewed {
    Path packing, scan, folder;                            // files; none: empty
    imaging::ImageConfig image = {};                       // how the scan is read
    std::optional<std::array<double, 3>> scan_low_m = {};  // in the packing's frame
    std::string title = {};
};

Viewed viewed_case(const Common& common) {
    const Case c = read_case(common.input);
    const Path packing = c.stage_folder("pack") / "packing.json", whole = std::filesystem::absolute(c.folder).lexically_normal();
    Viewed seen{.folder = c.results(),
                .image = c.settings.image,
                .title = (whole.filename().empty() ? whole.parent_path() : whole).filename().string()};
    if (std::filesystem::exists(packing)) seen.packing = packing;
    if (!c.settings.image.file.empty()) seen.scan = c.resolve(c.settings.image.file);
    if (seen.packing.empty() && seen.scan.empty())
        throw UserError("the case has no packing yet", {.where = common.input, .fix = "porepack pack " + common.input});
    if (!seen.packing.empty() && !seen.scan.empty())
        if (const auto& fit = c.result<results::Pack>().fit) seen.scan_low_m = fit->image_origin_m;
    return seen;
}

// A packing, a scan, or a packing that was fitted to a scan.
Viewed viewed_files(const Common& common, const std::string& scan) {
    const Path input = common.input;
    Viewed seen{.folder = input.parent_path(),
                .image = config_from_flags<imaging::ImageConfig>(common.image_flags),
                .title = input.filename().string()};
    if (is_packing(common.input)) {
        seen.packing = input;
        seen.scan = scan;
        if (const Path fit = seen.folder / "fit.result.json"; !scan.empty() && std::filesystem::exists(fit))
            seen.scan_low_m = from_json_members<results::Fit>(read_json(fit), fit.string()).image_origin_m;
    } else if (imaging::is_volume(input) && scan.empty()) {
        seen.scan = input;
    } else {
        throw UserError("neither a case nor a packing nor a scan",
                        {.where = common.input, .allowed = "a folder with case.toml, packing.json[.gz], an image of docs/images.md"});
    }
    return seen;
}

void view(const Common& common, bool no_open, const std::string& scan) {
    const bool of_case = is_case(common.input);
    if (of_case && (!scan.empty() || !common.image_flags.empty()))
        throw UserError("a case names its scan itself", {.where = common.input + ": [image]", .fix = "leave out --scan and --image-..."});
    const Viewed seen = of_case ? viewed_case(common) : viewed_files(common, scan);
    const Path page = common.output.empty() ? seen.folder / "view.html" : Path(common.output);
    std::optional<packing::Packing> packing;
    if (!seen.packing.empty()) packing = packing::read_packing(seen.packing);
    std::optional<imaging::VolumeSource> image;
    if (!seen.scan.empty()) image = imaging::open_volume(seen.scan, seen.image);
    if (packing && image && !seen.scan_low_m && !(image->header.own_phases || image->header.own_fractions))
        throw UserError("where the scan lies beside the grains is not known",
                        {.where = seen.packing.string(),
                         .allowed = "the packing.json of `porepack image fit`, with fit.result.json beside it, of this version or later"});
    if (common.dry_run)
        return print_result(common, {{"page", page.string()}, {"grains", packing ? packing->bodies.size() : 0}, {"expected", "seconds"}});
    report::BedView bed;
    if (packing) {
        std::optional<Interval> section;
        if (of_case) {
            const Case c = read_case(common.input);
            if (std::filesystem::exists(c.stage_folder("voxelise") / "result.json")) section = c.result<results::Voxelise>().section_m;
        }
        bed = analysis::bed_view_of(*packing, section);
        if (image) analysis::add_scan(bed, *image, seen.scan_low_m.value_or(image->header.origin_m));
    } else {
        bed = analysis::scan_view_of(*image);
    }
    if (of_case) analysis::add_flow(bed, read_case(common.input).stage_folder("lbm") / "flow.vti");
    report::write_bed_page(page, seen.title, bed);
    if (!no_open && has_display()) start({"xdg-open", std::filesystem::absolute(page).string()});
    print_result(common, {{"page", page.string()}});
}

// Of the package porepack-doc.
const Path installed_site = "/usr/share/doc/porepack/html/index.html";

// From the pages beside this program, in its source tree.
Path built_site(const Path& output) {
    Path script;
    try {
        script = data_file("scripts/build_docs");
    } catch (const UserError&) {
        throw UserError("the documents are not installed",
                        {.fix = "apt-get install porepack-doc, or build them in the sources: scripts/build_docs FOLDER"});
    }
    if (!find_program("sphinx-build"))
        throw EngineError("sphinx-build is not installed",
                          {.fix = "apt-get install --no-install-recommends python3-sphinx python3-myst-parser furo"});
    const ProgramEnd end = run_program({.command = {script.string(), std::filesystem::absolute(output).string()}});
    if (end.exit_code != 0) throw EngineError("the site could not be built", {.where = script.string()});
    return output / "index.html";
}

void show_documents(const Common& common, bool no_open) {
    const bool is_installed = common.output.empty() && std::filesystem::exists(installed_site);
    const Path output = common.output.empty() ? Path("porepack-docs") : Path(common.output);
    if (common.dry_run)
        return print_result(common,
                            {{"page", (is_installed ? installed_site : output / "index.html").string()}, {"expected", "half a minute"}});
    const Path page = is_installed ? installed_site : built_site(output);
    if (!no_open && has_display()) start({"xdg-open", std::filesystem::absolute(page).string()});
    print_result(common, {{"page", page.string()}});
}

}  // namespace

void add_view_command(CommandLine& line) {
    const auto no_open = std::make_shared<bool>(false), paraview = std::make_shared<bool>(false);
    const auto scan = std::make_shared<std::string>();
    auto command = line.add(
        "view", "a page on which the bed can be turned, cut and coloured, opened in the browser", "porepack view cases/quickstart",
        [&line, no_open, paraview, scan] { *paraview ? view_in_paraview(line.common, *no_open) : view(line.common, *no_open, *scan); });
    command.add_option("input", line.common.input, "a case, packing.json[.gz], or a scan (docs/images.md)").type_name("path").required();
    command.add_option("--scan", *scan, "the scan to which the grains of packing.json were fitted: its gray values on the cut")
        .type_name("path");
    line.add_image_keys(command, {"pore", "threshold", "pore_side", "walls", "smoothing_voxels", "gray_levels", "find_container",
                                  "fitted_sizes", "fit_memory_bytes"});
    command.add_flag("--no-open", *no_open, "write the page (view.html, or --output) only");
    command.add_flag("--paraview", *paraview,
                     "instead a script (results/view.py) that opens all results of a case in ParaView, and start it");
}

void add_docs_command(CommandLine& line) {
    const auto no_open = std::make_shared<bool>(false);
    auto command = line.add("docs", "all documents as a site with search, opened in the browser", "porepack docs",
                            [&line, no_open] { show_documents(line.common, *no_open); });
    command.add_flag("--no-open", *no_open,
                     "only say where the site is; without the package porepack-doc it is built in porepack-docs, or --output");
}

}  // namespace porepack::apps
