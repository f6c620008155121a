// What others published, what PorePack computes for the same beds, and whether both agree.
//
// A subject is a folder with published.csv (item, value, standard_uncertainty, unit, source), written before ours.csv (item, value, low,
// high, command, date, version), and control.csv, the same quantities with something made wrong on purpose (change, item, value, low, high,
// command, date, version): at least one of its rows has to disagree.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/interval.hpp"

namespace porepack::evidence {

struct Published {
    std::string item;
    double value = 0.0;
    std::optional<double> standard_uncertainty = {};  ///< none: the value is reported, without a verdict
    std::string unit, source;
};
struct Ours {
    std::string item;
    double value = 0.0;
    core::Interval interval;  ///< holds the value in 95 of 100
    std::string command, date, version;
    std::string change = {};  ///< of a control: what was made wrong
};

enum class Verdict { agrees, disagrees, none };
[[nodiscard]] std::string_view word_of(Verdict verdict);

struct Row {
    Published published;
    std::optional<Ours> ours = {};  ///< none: not computed yet
    bool control_agrees = false;    ///< a control of this quantity does not disagree: the comparison shows nothing
    [[nodiscard]] Verdict verdict() const;
    /// Ours over the published value, minus 1.
    [[nodiscard]] std::optional<double> difference() const;
};

struct Subject {
    std::string name, title;  ///< of its folder; of the first line of its README.md
    std::vector<Row> rows, controls;
    [[nodiscard]] int count(Verdict verdict) const;
    /// One of the controls disagrees.
    [[nodiscard]] bool control_disagrees() const;
};

/// Agree: |ours - theirs| <= 2 sqrt(u1^2 + u2^2), with u2 a quarter of the width of our interval. None without a published uncertainty, or
/// with one above 15 %, or without ours.
[[nodiscard]] Verdict verdict_of(const Published& published, const std::optional<Ours>& ours);

/// The subjects in this folder, by name. Throws UserError for a row that is not understood or stands twice, for rows of ours that nobody
/// published, and for an interval that does not hold its value.
[[nodiscard]] std::vector<Subject> read_evidence(const core::Path& folder);

/// The table in Markdown: a section per subject.
[[nodiscard]] std::string table_of(const std::vector<Subject>& subjects);

/// Ours over the published values, with both uncertainties, as a picture; its data are next to it. False without gnuplot.
bool draw_evidence(const core::Path& picture, const std::vector<Subject>& subjects);

}  // namespace porepack::evidence
