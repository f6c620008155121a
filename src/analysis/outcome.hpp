// What an analysis finds: its result, and the tables and pictures that belong to it, all in memory.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"
#include "core/table.hpp"
#include "io/stl.hpp"
#include "report/plot.hpp"

namespace porepack::analysis {

/// Drawn by gnuplot from the tables (report::draw_plot).
struct Plot {
    std::string file, script;
    report::PlotValues values = {};
    report::PlotSize size = {};
};
/// RGB, row by row from the top.
struct Picture {
    std::string file;
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels = {};
};
struct Files {
    std::vector<std::pair<std::string, core::Table>> tables = {};  ///< by the name of the file
    std::vector<Plot> plots = {};
    std::vector<Picture> pictures = {};
    std::vector<std::pair<std::string, io::Paths>> paths = {};  ///< .vtp
};

template <typename Result>
struct Outcome {
    Result result;
    Files files = {};
};

void write_files(const Files& files, const core::Path& folder);

/// Writes the tables and pictures into `folder` and returns the result.
template <typename Result>
[[nodiscard]] Result written(Outcome<Result> outcome, const core::Path& folder) {
    write_files(outcome.files, folder);
    return std::move(outcome.result);
}

}  // namespace porepack::analysis
