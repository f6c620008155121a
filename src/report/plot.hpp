// Plots by gnuplot, from the scripts in report/templates/.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/files.hpp"

namespace porepack::report {

/// Values that a script requires, by name.
using PlotValues = std::vector<std::pair<std::string, std::variant<double, std::string>>>;

struct PlotSize {
    int width = 620, height = 380, font = 12;  ///< points of an SVG; a PNG has twice as many pixels
};

/// Draws `picture` (.svg or .png) by the script templates/<script>.gnuplot; its data are next to the picture, and so is the script that
/// was run. Returns false, with a warning, without gnuplot. Throws EngineError when gnuplot fails.
bool draw_plot(const core::Path& picture, const std::string& script, const PlotValues& values = {}, const PlotSize& size = {});

}  // namespace porepack::report
