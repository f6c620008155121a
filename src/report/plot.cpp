#include "report/plot.hpp"

#include <fmt/format.h>

#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "core/process.hpp"
#include "report/uses.hpp"

namespace porepack::report {
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
    write_text(script, text + read_text(data_file("templates/" + script_name + ".gnuplot")));
    const Path log = picture.parent_path() / ("log." + picture.stem().string());
    const ProgramEnd end = run_program({.command = {"gnuplot", script.filename().string()}, .folder = picture.parent_path(), .log = log});
    if (end.exit_code != 0) throw EngineError("gnuplot failed\n" + tail(log, 5), {.where = script.string()});
    std::filesystem::remove(log);
    return true;
}

}  // namespace porepack::report
