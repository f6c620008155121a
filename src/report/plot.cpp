#include "report/plot.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <sstream>

#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/process.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

// What gnuplot is asked after it has drawn: the frame in pixels and its ends, and all settings, of which only logarithmic axes are read.
const char* const questions =
    "set print '{0}.axes'; print sprintf('%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %g', GPVAL_TERM_XMIN, GPVAL_TERM_XMAX, GPVAL_TERM_YMIN, "
    "GPVAL_TERM_YMAX, GPVAL_X_MIN, GPVAL_X_MAX, GPVAL_Y_MIN, GPVAL_Y_MAX, GPVAL_TERM_YSIZE/GPVAL_TERM_SCALE); set print; "
    "save set '{0}.settings'";

// Writes the axes into the picture, from which a page reads the values under the pointer: pixels from the upper left corner.
void add_axes(const Path& picture) {
    Path axes = picture, settings = picture;
    axes.replace_extension(".axes");
    settings.replace_extension(".settings");
    std::istringstream numbers(read_text(axes));
    const std::string set = read_text(settings);
    std::array<double, 9> n{};
    for (double& number : n) numbers >> number;
    if (!numbers) return;
    const auto is_logarithmic = [&](char axis) {
        return set.find(std::string("\nset logscale ") + axis + ' ') != std::string::npos;  // a line for each
    };
    const Json json = {{"pixels", {n[0], n[1], n[8] - n[3], n[8] - n[2]}},
                       {"x", {n[4], n[5]}},
                       {"y", {n[6], n[7]}},
                       {"log_x", is_logarithmic('x')},
                       {"log_y", is_logarithmic('y')}};
    std::string svg = read_text(picture);
    svg.insert(svg.find("<svg") + 4, " data-axes='" + json.dump() + "'");
    write_text(picture, svg);
    std::filesystem::remove(axes);
    std::filesystem::remove(settings);
}

}  // namespace

bool draw_plot(const Path& picture, const std::string& script_name, const PlotValues& values, const PlotSize& size) {
    if (!find_program("gnuplot")) {
        log_warning("no plots: gnuplot is not installed (apt-get install gnuplot-nox)");
        return false;
    }
    require_plain_name(picture.filename().string(), "the name of a picture", picture.string());
    const bool png = picture.extension() == ".png";
    std::string text =
        png ? fmt::format("set terminal pngcairo size {},{} font 'DejaVu Sans,{}'\n", 2 * size.width, 2 * size.height, 2 * size.font - 2)
            : fmt::format("set terminal svg size {},{} font 'DejaVu Sans,{}' background 'white'\n", size.width, size.height, size.font);
    text += fmt::format("set output {}\nset grid lc rgb '#dddddd'\nset border 3\nset tics nomirror\n",
                        for_gnuplot(picture.filename().string()));
    for (const auto& [name, value] : values)
        text += std::holds_alternative<double>(value) ? fmt::format("{} = {:.12g}\n", name, std::get<double>(value))
                                                      : fmt::format("{} = {}\n", name, for_gnuplot(std::get<std::string>(value)));
    const Path script = picture.parent_path() / (picture.stem().string() + ".gnuplot");
    const std::string body = read_text(data_file("templates/" + script_name + ".gnuplot"));
    write_text(script, text + body);
    const Path log = picture.parent_path() / ("log." + picture.stem().string());
    const bool one_frame = !png && body.find("multiplot") == std::string::npos;
    std::vector<std::string> command = {"gnuplot", script.filename().string()};
    if (one_frame) command.insert(command.end(), {"-e", fmt::format(fmt::runtime(questions), picture.stem().string())});
    const ProgramEnd end = run_program({.command = command, .folder = picture.parent_path(), .log = log});
    if (end.exit_code != 0) throw EngineError("gnuplot failed\n" + tail(log, 5), {.where = script.string()});
    std::filesystem::remove(log);
    if (one_frame) add_axes(picture);
    return true;
}

}  // namespace porepack::report
