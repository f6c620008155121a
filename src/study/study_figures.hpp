// Figures and page of a study.
#pragma once

#include "study/study.hpp"

namespace porepack::study {

/// Draws the current rows to figures/<name>.svg and .png; their data are in figures/<name>.dat. False without gnuplot. Throws UserError for
/// unknown columns and for columns without numbers.
bool draw_figure(const Study& study, const FigureConfig& figure);

/// All figures of study.toml, and study.html with them, the table of points and links to their reports.
void write_study_page(const Study& study);

}  // namespace porepack::study
