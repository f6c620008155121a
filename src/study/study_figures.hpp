// Figures and page of a study.
#pragma once

#include <string>

#include "study/study.hpp"

namespace porepack::study {

/// Which rows of study.csv are drawn: those of these settings and of this version; or, of points without such a row, also their newest
/// other.
enum class RowChoice { current, with_stale };

/// Draws the rows to figures/<name>.svg and .png; their data are in figures/<name>.dat. False without gnuplot. Throws UserError for
/// unknown columns and for columns without numbers.
bool draw_figure(const Study& study, const FigureConfig& figure, RowChoice choice = RowChoice::current);

/// "permeability_m2" is shown as "permeability (m²)".
[[nodiscard]] std::string label_of(const std::string& column);

/// All figures of study.toml, and study.html with them, the table of points and links to their reports. With `beds`, a page of each
/// point's bed too, which study.html shows.
void write_study_page(const Study& study, RowChoice choice = RowChoice::current, bool beds = false);

}  // namespace porepack::study
