// Runs the points of a study, several at once, and tells how far it is.
#pragma once

#include "study/study.hpp"

namespace porepack::study {

struct StudyRunOptions {
    std::string points = {};  ///< as for chosen_points()
    double max_time_s = 0.0;  ///< no point begins after this time; 0: no limit
};

/// Runs the points that have no current row in study.csv, and adds their rows. A point that fails does not stop the others; a point that
/// another process runs is left to it. Returns what was done: points, done, current_before, failed (with messages), elsewhere, not_begun.
core::Json run_study(const Study& study, const StudyRunOptions& options);

/// What run_study() would need: each point with its state and expectation, and the sums. Nothing is written.
[[nodiscard]] core::Json plan_study(const Study& study, const StudyRunOptions& options);

/// The state of each point: done (a current row), stale (only a row of other settings or versions), running, failed (with its message),
/// missing.
[[nodiscard]] core::Json status_of(const Study& study);

}  // namespace porepack::study
