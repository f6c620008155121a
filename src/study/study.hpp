// A study: one case with several values of some keys. It is a folder with study.toml; each point of it is a case of its own.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/choice.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "pipeline/stage.hpp"
#include "record/config.hpp"
#include "stages/case.hpp"

namespace porepack::study {

enum class Spacing { linear, logarithmic };
constexpr std::array<core::Choice<Spacing>, 2> choices_of(Spacing) {
    return {{{Spacing::linear, "linear"}, {Spacing::logarithmic, "logarithmic"}}};
}

/// One or more keys that change together. The axes are crossed.
struct AxisConfig {
    core::Json key;     ///< "shape.sphericity", or a list of keys
    core::Json values;  ///< of the key; of several keys, a list of lists
    double from = 0.0, to = 0.0;
    long number = 0;
    Spacing spacing = Spacing::linear;
};
void describe(record::ConfigVisitor& v, AxisConfig& c);

/// A column that follows from others.
struct ColumnConfig {
    std::string name, formula;
};
void describe(record::ConfigVisitor& v, ColumnConfig& c);

enum class CurveForm { polynomial, exponential, power, logarithmic, given };
constexpr std::array<core::Choice<CurveForm>, 5> choices_of(CurveForm) {
    return {{{CurveForm::polynomial, "polynomial"},
             {CurveForm::exponential, "exponential"},
             {CurveForm::power, "power"},
             {CurveForm::logarithmic, "logarithmic"},
             {CurveForm::given, "given"}}};
}

/// A curve through y(x), fitted or given.
struct FitConfig {
    std::string name, x, y, by;
    CurveForm form = CurveForm::polynomial;
    long degree = 1;        ///< of a polynomial
    std::string formula;    ///< of x, form = given
    bool relative = false;  ///< form = given: residuals of ln y
};
void describe(record::ConfigVisitor& v, FitConfig& c);

struct FigureConfig {
    std::string name, x, y, by;
    bool logarithmic = false, logarithmic_x = false;
    core::Json fits;    ///< names of fits of the same x and y
    core::Json curves;  ///< {title, formula of x} each
    core::Json marks;   ///< {title, x, y} each
};
void describe(record::ConfigVisitor& v, FigureConfig& c);

struct StudyConfig {
    std::string base = ".";
    std::string up_to = "report";
    std::vector<AxisConfig> axes;
    std::vector<core::Json> left_out;
    std::vector<ColumnConfig> columns;
    std::vector<FitConfig> fits;
    std::vector<FigureConfig> figures;
};
void describe(record::ConfigVisitor& v, StudyConfig& c);

/// A case of a study: "tetrapod_0.53".
struct Point {
    std::string name;
    std::vector<std::pair<std::string, core::Json>> values;  ///< "shape.sphericity" -> 0.53
    stages::Case planned;                                    ///< the base case with these values; its results are those of the point
    core::Json identity;                                     ///< all that determines the results (pipeline::identity_of)
    std::string digest;                                      ///< of the identity, the same on every machine
};

struct Study {
    core::Path folder;
    StudyConfig config;
    std::vector<std::string> keys;  ///< of all axes
    std::vector<Point> points;      ///< in the order of the axes, the last one fastest

    [[nodiscard]] core::Path folder_of(const Point& point) const { return folder / "points" / point.name; }
    [[nodiscard]] core::Path table() const { return folder / "study.csv"; }
};

/// `path` is the study's folder or its study.toml. Throws UserError for what it does not understand, for a key that no case has, and for
/// points that would have the same name.
[[nodiscard]] Study read_study(const core::Path& path);

/// Those named: "tetrapod_0.53,7,10-12" (names, or numbers from 1). Throws UserError for an unknown one. All of them if `names` is empty.
[[nodiscard]] std::vector<Point> chosen_points(const Study& study, const std::string& names);

/// The stages of the points that `up_to` leaves out, and that a case has which is run on its own.
[[nodiscard]] std::vector<std::string> stages_left_out(const Study& study);

/// Writes points/<name>/case.toml if its content would change, and returns the case: it can also be run on its own.
stages::Case write_point(const Study& study, const Point& point);

/// What the stages of the point that are not done will need. A point that cannot be run fails when it is run; here, the text says why.
[[nodiscard]] core::Expectation expectation_of(const Study& study, const Point& point);

}  // namespace porepack::study
