// Curves fitted to the columns of a study, and published curves held against them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/interval.hpp"
#include "study/study.hpp"
#include "study/study_table.hpp"

namespace porepack::study {

struct Coefficient {
    std::string name;
    double value = 0.0;
    core::Interval interval = {};  ///< 95 %, Student's t
};

/// y as a function of x for one group of points.
struct FittedCurve {
    std::string fit, group;  ///< the group's value of `by`; empty without it
    std::size_t points = 0;
    std::vector<Coefficient> coefficients;  ///< none for a given formula
    bool in_logarithm = false;              ///< the next two are of ln y: relative errors
    double bias = 0.0;                      ///< mean of curve - points
    double residual = 0.0;                  ///< standard deviation of the residuals, with the degrees of freedom of the fit
    double r_squared = 0.0;                 ///< of what was fitted: y, or ln y
    double x_low = 0.0, x_high = 0.0;       ///< range of its points
    std::string text;                       ///< "1.63 - 0.0124 x"
    std::function<double(double)> value;    ///< empty, and `text` says so, where there are too few points
};

/// Least squares without weights: polynomials and logarithmic curves in y, exponential curves and powers in ln y. Throws UserError for
/// values without a logarithm.
[[nodiscard]] std::vector<FittedCurve> fitted_curves(const std::vector<StudyRow>& rows, const FitConfig& fit);

/// The [[column]]s of study.toml, as fields of each row; empty where a variable is missing.
[[nodiscard]] std::vector<StudyRow> with_columns(std::vector<StudyRow> rows, const StudyConfig& config);

/// The number in a field; NaN if it is empty or missing. Throws UserError for text.
[[nodiscard]] double number_in(const StudyRow& row, const std::string& column);

/// fits.csv: one line per coefficient, or one per given formula.
void write_fits(const std::vector<FittedCurve>& curves, const core::Path& file);

}  // namespace porepack::study
