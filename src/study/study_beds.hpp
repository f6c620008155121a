// The beds of a study's points, one beside the points in study.html.
#pragma once

#include <string>
#include <vector>

#include "study/study.hpp"
#include "study/study_table.hpp"

namespace porepack::study {

/// Writes points/NAME/view.html for each row whose point has a packing, and returns HTML for the page: the rows as points of the columns x
/// and y, and a frame with the bed of the one that is chosen. Empty where no point has a packing. Throws EngineError without libjs-three.
[[nodiscard]] std::string beds_html(const Study& study, const std::vector<StudyRow>& rows, const std::string& x, const std::string& y,
                                    bool logarithmic);

}  // namespace porepack::study
