// A measured water level against time, from a CSV file.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "falling_head/config.hpp"

namespace porepack::falling_head {

struct LevelCurve {
    std::string name;     ///< path of the file
    std::string packing;  ///< from a line "# packing: NAME"; curves of one packing share their permeability
    std::vector<double> time_s, level_m;
    std::vector<std::string> warnings = {};
    bool doubtful = false;  ///< a warning says that results from the curve may be meaningless (all warnings except gaps)
};

/// CSV in UTF-8. A header line names the two columns with their units: time_s, time_ms or time_min; level_m, level_cm or level_mm (further
/// columns are ignored). Its separator is that of the file: semicolon, tab or comma; with the first two a decimal comma is accepted. '#'
/// starts a comment. Times must increase. Throws UserError with the line.
[[nodiscard]] LevelCurve read_level_curve(const core::Path& csv);

/// The part of the curve between the first level below the window's top and the last one above its bottom, with warnings about what
/// looks wrong: gaps, jumps, rising levels, levels and speeds that are impossible for a column of water (units). UserError when fewer than
/// five points are left, when the level does not fall, or when the data end above the window.
[[nodiscard]] LevelCurve take_window(const LevelCurve& curve, const FallingHeadConfig& config);

/// Standard deviation of the levels' noise, from second differences (0.6745 is the normal distribution's median): trends and single
/// jumps do not count. At least 1e-7 m.
[[nodiscard]] double noise_of(const LevelCurve& curve);

}  // namespace porepack::falling_head
