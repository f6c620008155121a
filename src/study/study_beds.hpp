// The beds of a study's points, one beside the points in study.html.
#pragma once

#include <string>
#include <vector>

#include "study/study.hpp"
#include "study/study_table.hpp"

namespace porepack::study {

/// A bed of several, at its place in a plot.
struct BedPoint {
    std::string name, page;  ///< page: from the page that shows it
    double x, y;
};
/// The page of a bed: `results` has pack/packing.json and, perhaps, lbm/flow.vti. Throws EngineError without libjs-three.
void write_bed(const core::Path& results, const core::Path& page, const std::string& title);
/// HTML for a page: the points, and a frame with the bed of the one that is chosen. Empty without points.
[[nodiscard]] std::string choice_of_beds(const std::vector<BedPoint>& points, const std::string& x_label, const std::string& y_label,
                                         bool logarithmic);

/// Writes points/NAME/view.html for each row whose point has a packing, and returns HTML for the page: the rows as points of the columns x
/// and y, and a frame with the bed of the one that is chosen. Empty where no point has a packing. Throws EngineError without libjs-three.
[[nodiscard]] std::string beds_html(const Study& study, const std::vector<StudyRow>& rows, const std::string& x, const std::string& y,
                                    bool logarithmic);

}  // namespace porepack::study
