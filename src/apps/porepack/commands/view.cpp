// What opens in a browser, or in ParaView: the bed in three dimensions, and the documents.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "analysis/bed_view.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/process.hpp"
#include "imaging/volume.hpp"
#include "packing/packing.hpp"
#include "report/paraview.hpp"
#include "results/fit.hpp"
#include "results/geometry.hpp"
#include "results/pack.hpp"
#include "stages/case_space.hpp"

namespace porepack::apps {
namespace {

using report::BedView;

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

std::string name_of_folder(const Path& path) {
    const Path whole = std::filesystem::absolute(path).lexically_normal();
    return (whole.filename().empty() ? whole.parent_path() : whole).filename().string();
}

// The image is that of the fit: as long along each axis, within a voxel, and read with the same axes.
void require_image_of(const results::Fit& fit, const imaging::VolumeHeader& image, const std::string& where) {
    for (std::size_t a = 0; a < 3; ++a) {
        const double length = static_cast<double>(image.voxels[a]) * image.spacing_m[a],
                     fitted = static_cast<double>(fit.file.voxels[a]) * fit.file.voxel_size_m[a];
        if (std::abs(length - fitted) > std::max(image.spacing_m[a], fit.file.voxel_size_m[a]))
            throw UserError(fmt::format("the image is {:.4g} m long along {}, and the one of the fit {:.4g} m", length, "xyz"[a], fitted),
                            {.where = where, .fix = "the scan of the fit, with the same --image-voxel-size and --image-axes"});
    }
    if (image.orientation != fit.file.orientation)
        throw UserError("the image is read with other axes than in the fit: " + image.orientation,
                        {.where = where, .allowed = fit.file.orientation, .fix = "the same --image-axes"});
}

// Grains and scan of a case, and the flow through them.
BedView view_of_case(const Case& c, const std::string& input) {
    const Path file = c.stage_folder("pack") / "packing.json",
               scan = c.settings.image.file.empty() ? Path() : c.resolve(c.settings.image.file);
    const bool has_packing = std::filesystem::exists(file);
    if (!has_packing && scan.empty()) throw UserError("the case has no packing yet", {.where = input, .fix = "porepack pack " + input});
    BedView bed;
    if (has_packing) {
        std::optional<Interval> section;
        if (std::filesystem::exists(c.stage_folder("voxelise") / "result.json")) section = c.result<results::Voxelise>().section_m;
        bed = analysis::bed_view_of(packing::read_packing(file), section);
        const auto& fit = c.result<results::Pack>().fit;
        if (fit && fit->image_origin_m && std::filesystem::exists(scan))
            analysis::add_scan(bed, imaging::open_volume(scan, c.settings.image), *fit->image_origin_m);
        else if (!scan.empty())
            log_warning(fmt::format("{} is not shown: it is gone, or the grains were fitted by an earlier version", scan.string()));
    } else {
        const imaging::VolumeSource image = imaging::open_volume(scan, c.settings.image);
        const Path placed = c.stage_folder("image") / stages::image_file(c);
        bed = analysis::scan_view_of(
            image, std::filesystem::exists(placed) ? imaging::open_volume(placed).header.origin_m : image.header.origin_m);
    }
    analysis::add_flow(bed, c.stage_folder("lbm") / "flow.vti");
    return bed;
}

// A packing, a scan, or a packing beside the scan to which it was fitted.
BedView view_of_file(const Common& common, const std::string& scan) {
    const auto config = config_from_flags<imaging::ImageConfig>(common.image_flags);
    if (!is_packing(common.input)) {
        if (!imaging::is_volume(common.input) || !scan.empty())
            throw UserError("neither a case nor a packing nor a scan",
                            {.where = common.input, .allowed = "a folder with case.toml, packing.json[.gz], an image of docs/images.md"});
        const imaging::VolumeSource image = imaging::open_volume(common.input, config);
        return analysis::scan_view_of(image, image.header.origin_m);
    }
    if (scan.empty() && !common.image_flags.empty())
        throw UserError("--image-... have no effect without --scan", {.where = common.input, .fix = "remove them, or name the scan"});
    BedView bed = analysis::bed_view_of(packing::read_packing(common.input));
    if (scan.empty()) return bed;
    const imaging::VolumeSource image = imaging::open_volume(scan, config);
    if ((image.header.own_phases || image.header.own_fractions) && image.header.notes.contains("container")) {
        analysis::add_scan(bed, image, image.header.origin_m);  // it lies where the packing does
        return bed;
    }
    const Path file = Path(common.input).parent_path() / "fit.result.json";
    const auto fit =
        std::filesystem::exists(file) ? std::optional(from_json_members<results::Fit>(read_json(file), file.string())) : std::nullopt;
    if (!fit || !fit->image_origin_m)
        throw UserError("where the scan lies beside the grains is not known",
                        {.where = common.input,
                         .allowed = "the packing.json of `porepack image fit`, with fit.result.json beside it, of this version or later"});
    require_image_of(*fit, image.header, scan);
    analysis::add_scan(bed, image, *fit->image_origin_m);
    return bed;
}

void view(const Common& common, bool no_open, const std::string& scan) {
    const bool of_case = is_case(common.input);
    if (of_case && (!scan.empty() || !common.image_flags.empty()))
        throw UserError("a case names its scan itself", {.where = common.input + ": [image]", .fix = "leave out --scan and --image-..."});
    const Case c = of_case ? read_case(common.input) : Case();
    const Path folder =
                   of_case ? c.results() : std::filesystem::absolute(common.input + "/").lexically_normal().parent_path().parent_path(),
               page = common.output.empty() ? folder / "view.html" : Path(common.output);
    const BedView bed = of_case ? view_of_case(c, common.input) : view_of_file(common, scan);
    if (common.dry_run) return print_result(common, {{"page", page.string()}, {"grains", bed.grains.size()}, {"expected", "seconds"}});
    report::write_bed_page(page, name_of_folder(of_case ? c.folder : Path(common.input)), bed);
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
                          {.fix = "apt-get install --no-install-recommends python3-sphinx python3-myst-parser furo doxygen"});
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
    auto command = line.add("view", "a page on which the bed can be turned, cut and coloured, opened in the browser",
                            "porepack view cases/quickstart", [&line, no_open, paraview, scan] {
                                if (!*paraview) return view(line.common, *no_open, *scan);
                                if (!scan->empty() || !line.common.image_flags.empty())
                                    throw UserError("--scan and --image-... have no effect with --paraview", {.fix = "remove them"});
                                view_in_paraview(line.common, *no_open);
                            });
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
