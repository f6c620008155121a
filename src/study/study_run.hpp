// Runs the points of a study, several at once, and tells how far it is.
#pragma once

#include <string>
#include <vector>

#include "core/members.hpp"
#include "study/study.hpp"

namespace porepack::study {

struct StudyRunOptions {
    std::string points = {};  ///< as for chosen_points()
    double max_time_s = 0.0;  ///< no point begins after this time; 0: no limit
};

/// A point that failed, with its message.
struct FailedPoint {
    std::string point, error;
};
template <core::MembersOf<FailedPoint> Self, typename Visit>
void visit_members(Self& failed, const Visit& visit) {
    visit("point", failed.point);
    visit("error", failed.error);
}

/// What a run of a study did.
struct StudyRunResult {
    std::size_t points = 0;  ///< that were chosen
    std::size_t current_before = 0;
    std::vector<std::string> done;
    std::vector<FailedPoint> failed;
    std::vector<std::string> elsewhere;  ///< another process runs them
    std::size_t not_begun = 0;           ///< when the time was over
    std::string table;
};
template <core::MembersOf<StudyRunResult> Self, typename Visit>
void visit_members(Self& result, const Visit& visit) {
    visit("points", result.points);
    visit("current_before", result.current_before);
    visit("done", result.done);
    visit("failed", result.failed);
    visit("elsewhere", result.elsewhere);
    visit("not_begun", result.not_begun);
    visit("table", result.table);
}

/// done (a current row), stale (only a row of other settings or versions), running, interrupted, failed, missing.
struct PointStatus {
    std::string point, state;
    std::string why = {};  ///< why it is not done
};
template <core::MembersOf<PointStatus> Self, typename Visit>
void visit_members(Self& status, const Visit& visit) {
    visit("point", status.point);
    visit("state", status.state);
    visit("why", status.why);
}

struct PlannedPoint {
    std::string point, state;
    std::string expected;  ///< memory, time and disk space
};
template <core::MembersOf<PlannedPoint> Self, typename Visit>
void visit_members(Self& planned, const Visit& visit) {
    visit("point", planned.point);
    visit("state", planned.state);
    visit("expected", planned.expected);
}

/// What a run of a study would need.
struct StudyPlan {
    std::vector<PlannedPoint> points;
    int at_once = 1;
    std::string expected;               ///< of all
    std::vector<std::string> left_out;  ///< stages that `up_to` leaves out
    std::string memory_available;
    core::OptionalKey<std::string> max_time = {};  ///< how much of it max_time_s allows
};
template <core::MembersOf<StudyPlan> Self, typename Visit>
void visit_members(Self& plan, const Visit& visit) {
    visit("points", plan.points);
    visit("at_once", plan.at_once);
    visit("expected", plan.expected);
    visit("left_out", plan.left_out);
    visit("memory_available", plan.memory_available);
    visit("max_time", plan.max_time);
}

/// Runs the points that have no current row in study.csv, and adds their rows. A point that fails does not stop the others; a point that
/// another process runs is left to it.
StudyRunResult run_study(const Study& study, const StudyRunOptions& options);

/// Nothing is written.
[[nodiscard]] StudyPlan plan_study(const Study& study, const StudyRunOptions& options);

[[nodiscard]] std::vector<PointStatus> status_of(const Study& study);

}  // namespace porepack::study
