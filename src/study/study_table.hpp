// study.csv: one row for each finished point of a study, with all that is needed to use it without the point's folder.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "study/study.hpp"

namespace porepack::study {

/// Column -> field; a missing column is an empty field.
using StudyRow = std::map<std::string, std::string>;

/// The rows of study.csv, none if there is no such file. Throws UserError for a file that is not such a table.
[[nodiscard]] std::vector<StudyRow> read_rows(const Study& study);
/// The row is of the point with its present settings and versions.
[[nodiscard]] bool is_current(const StudyRow& row, const Point& point);
[[nodiscard]] bool has_current_row(const std::vector<StudyRow>& rows, const Point& point);

/// The row of a point whose stages are done; `made` is its case.
[[nodiscard]] StudyRow row_of(const Point& point, const stages::Case& made);

/// Adds a row, or replaces that of the same point and digest. Rows of other digests stay, with `current` = no. Processes on one folder
/// take turns.
void add_row(const Study& study, const StudyRow& row);

/// The column that a user means: its name, the only one that ends in ".name" or starts with "name_" and a unit. Throws UserError.
[[nodiscard]] std::string column_named(const std::vector<StudyRow>& rows, const std::string& name);

/// "permeability_m2" -> "permeability_low_m2".
[[nodiscard]] std::string with_suffix(const std::string& column, const std::string& suffix);

}  // namespace porepack::study
