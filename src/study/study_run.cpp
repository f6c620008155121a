#include "study/study_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/file_lock.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "study/case_pipeline.hpp"
#include "study/scheduler.hpp"
#include "study/study_table.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
namespace {

// More points than this are not all asked for their memory before a run.
constexpr std::size_t points_asked = 24;

Path error_file(const Study& study, const Point& point) {
    return study.folder_of(point) / "error.txt";
}
Path lock_file(const Study& study, const Point& point) {
    return study.folder_of(point) / ".lock";
}

// Empty if nothing is left out.
std::string left_out_text(const Study& study) {
    const std::vector<std::string> left_out = stages_left_out(study);
    return left_out.empty() ? std::string() : fmt::format("up_to = \"{}\" leaves out {}", study.config.up_to, fmt::join(left_out, ", "));
}

// Two points whose numbers will be the same: a key of an axis has no effect. Empty if there are none.
std::string doubled_text(const Study& study) {
    std::map<std::string, const Point*> by_digest;
    for (const Point& point : study.points) {
        const auto [first, is_new] = by_digest.emplace(point.digest, &point);
        if (is_new) continue;
        std::vector<std::string> keys;
        for (std::size_t i = 0; i < point.values.size(); ++i)
            if (point.values[i] != first->second->values[i]) keys.push_back(point.values[i].first);
        return fmt::format("{} and {} are the same computation: {} changes nothing up to the stage {} (up_to)", first->second->name,
                           point.name, fmt::join(keys, ", "), study.config.up_to);
    }
    return {};
}

class StudyRun {
public:
    StudyRun(const Study& study, const StudyRunOptions& options) : study_(study), options_(options) {}

    StudyRunResult run() {
        std::vector<Point> chosen = chosen_points(study_, options_.points);
        const std::size_t all = chosen.size();
        std::erase_if(chosen, [rows = read_rows(study_)](const Point& point) { return has_current_row(rows, point); });
        todo_ = std::move(chosen);
        result_.current_before = all - todo_.size();
        if (!todo_.empty()) {
            if (const std::string text = left_out_text(study_); !text.empty()) log_info("study: {}", text);
            if (const std::string text = doubled_text(study_); !text.empty()) log_warning("study: " + text);
            const double memory = largest_memory();
            const int at_once = jobs_at_once(memory);
            log_info("study: {} of {} points to run, up to {} at once, about {} each", todo_.size(), all, at_once, human_bytes(memory));
            run_jobs(
                at_once, [this] { return next(); }, [this](const JobEnd& end) { ended(end); });
        }
        result_.points = all;
        result_.not_begun = todo_.size() - begun_;
        result_.table = study_.table().string();
        return result_;
    }

private:
    [[nodiscard]] double largest_memory() const {
        double largest = 0.0;
        // Evenly spread over the points: the axes are crossed, so neighbours are alike.
        const std::size_t step = (todo_.size() + points_asked - 1) / points_asked;
        for (std::size_t i = 0; i < todo_.size(); i += step) largest = std::max(largest, expectation_of(study_, todo_[i]).memory_bytes);
        return largest;
    }

    // Several processes may run one study. A process takes the lock of a point before it begins it, and keeps it until the row is written;
    // points that are locked are left to their owner. The table is read again under the lock, because the owner may have ended the point
    // since. A point whose stages are done but which has no row, as after an interruption between the two, gets its row without a run.
    std::optional<Job> next() {
        while (begun_ < todo_.size() && (options_.max_time_s <= 0.0 || watch_.seconds() < options_.max_time_s)) {
            const Point& point = todo_[begun_++];
            make_folder(study_.folder_of(point));
            std::optional<FileLock> lock = FileLock::try_take(lock_file(study_, point));
            if (!lock) {
                result_.elsewhere.push_back(point.name);
                continue;
            }
            if (has_current_row(read_rows(study_), point)) continue;  // another process has just ended it
            const Case made = write_point(study_, point);
            fs::remove(error_file(study_, point));
            if (is_done(case_pipeline(made), study_.config.up_to)) {
                take(point, made);
                continue;
            }
            running_.emplace(point.name, Running{point, made, std::move(*lock)});
            show();
            make_folder(made.results());
            return Job{.name = point.name,
                       .arguments = {"run", fs::absolute(made.folder).string(), "--up-to", study_.config.up_to},
                       .log = made.results() / "log.porepack"};
        }
        return std::nullopt;
    }

    void take(const Point& point, const Case& made) {
        add_row(study_, row_of(point, made));
        result_.done.push_back(point.name);
    }

    void ended(const JobEnd& end) {
        const auto found = running_.find(end.name);
        const auto& [point, made, lock] = found->second;
        if (end.error.empty()) {
            take(point, made);
        } else {
            write_text(error_file(study_, point), end.error + "\n");
            result_.failed.push_back({point.name, end.error});
            log_warning(fmt::format("study: {} failed: {}", point.name, end.error));
        }
        running_.erase(found);
        show();
    }

    void show() {
        const double ended = static_cast<double>(result_.done.size() + result_.failed.size()), all = static_cast<double>(todo_.size());
        progress_.update(ended / all, fmt::format("{} of {} points done, {} running, {} failed", result_.done.size(), todo_.size(),
                                                  running_.size(), result_.failed.size()));
    }

    struct Running {
        Point point;
        Case made;
        FileLock lock;
    };
    const Study& study_;
    const StudyRunOptions& options_;
    std::vector<Point> todo_;
    std::size_t begun_ = 0;
    StudyRunResult result_;
    std::map<std::string, Running> running_;
    Stopwatch watch_;
    Progress progress_{"study"};
};

PointStatus status_of(const Study& study, const Point& point, const std::vector<StudyRow>& rows) {
    const auto status = [&](const char* state, const std::string& why = {}) { return PointStatus{point.name, state, why}; };
    if (has_current_row(rows, point)) return status("done");
    const Path folder = study.folder_of(point);
    if (fs::exists(lock_file(study, point)) && !FileLock::try_take(lock_file(study, point))) return status("running");
    if (fs::exists(error_file(study, point))) {
        std::string message = read_text(error_file(study, point));
        while (!message.empty() && message.back() == '\n') message.pop_back();
        return status("failed", message);
    }
    if (std::any_of(rows.begin(), rows.end(), [&](const StudyRow& row) { return row.at("point") == point.name; }))
        return status("stale", "its row is of other settings or of another version");
    return status(fs::exists(folder / "results") ? "interrupted" : "missing");
}

}  // namespace

StudyRunResult run_study(const Study& study, const StudyRunOptions& options) {
    return StudyRun(study, options).run();
}

namespace {

// What the points that are not done will need. Points that differ in their seed alone need the same, and after some time, no more are
// asked: the sums then follow from those that were.
class Expectations {
public:
    explicit Expectations(const Study& study) : study_(study) {}

    // Nothing if it was not asked.
    [[nodiscard]] std::optional<Expectation> of(const Point& point) {
        Json tables = point.planned.settings.resolved_tables();
        tables["packing"].erase("seed");
        const std::string key = tables.dump();
        auto found = known_.find(key);
        if (found == known_.end()) {
            if (!known_.empty() && watch_.seconds() > max_processor_seconds) return std::nullopt;
            found = known_.emplace(key, expectation_of(study_, point)).first;
        }
        return found->second;
    }

private:
    static constexpr double max_processor_seconds = 30.0;
    const Study& study_;
    std::map<std::string, Expectation> known_;
    Stopwatch watch_;
};

// 0 to count - 1, each once, so that any number of the first ones is spread over all.
// Steps of the golden section spread the first values evenly. A step without a common divisor with `count` visits each number once.
std::vector<std::size_t> spread_order(std::size_t count) {
    auto step = static_cast<std::size_t>(0.618 * static_cast<double>(count)) + 1;
    while (std::gcd(step, count) != 1) ++step;
    std::vector<std::size_t> order(count);
    for (std::size_t i = 0; i < count; ++i) order[i] = i * step % count;
    return order;
}

}  // namespace

// Each job has its share of the threads, and the stages that use only one, such as a pour, run beside each other.
StudyPlan plan_study(const Study& study, const StudyRunOptions& options) {
    const std::vector<StudyRow> rows = read_rows(study);
    const std::vector<Point> points = chosen_points(study, options.points);
    const int threads = thread_count(), share = std::max(1, threads / static_cast<int>(std::min<std::size_t>(points.size(), 1024)));
    StudyPlan plan;
    plan.points.resize(points.size());
    Expectation all;
    const double slow = slowness();
    // Expected times depend on the number of threads: those of one job.
    set_thread_count(share);
    Expectations expectations(study);
    Progress progress("expected time and memory");
    std::size_t to_run = 0, asked = 0, seen = 0;
    for (const std::size_t i : spread_order(points.size())) {
        const std::string state = status_of(study, points[i], rows).state;
        std::string text = "nothing";
        if (state != "done") {
            ++to_run;
            if (const std::optional<Expectation> each = expectations.of(points[i])) {
                ++asked;
                all.memory_bytes = std::max(all.memory_bytes, each->memory_bytes);
                all.wall_time_s += each->wall_time_s;
                all.disk_bytes += each->disk_bytes;
                text = text_of(*each, slow);
            } else {
                text = "as the others, on average";
            }
        }
        plan.points[i] = {points[i].name, state, text};
        progress.update(static_cast<double>(++seen) / static_cast<double>(points.size()));
    }
    set_thread_count(threads);
    const int at_once = std::min(jobs_at_once(all.memory_bytes), std::max(1, threads / share));
    // Times and disk space grow with the number of points; memory with the number of points at once.
    const double of_asked = asked > 0 ? static_cast<double>(to_run) / static_cast<double>(asked) : 1.0;
    all.memory_bytes *= at_once;
    all.wall_time_s *= of_asked / at_once;
    all.disk_bytes *= of_asked;
    plan.at_once = at_once;
    plan.expected = text_of(all, slow) + (asked < to_run ? fmt::format(" (from {} of {} points)", asked, to_run) : "");
    plan.left_out = stages_left_out(study);
    plan.memory_available = human_bytes(available_memory_bytes());
    if (const std::string text = doubled_text(study); !text.empty()) log_warning("study: " + text);
    // A point that has begun is finished.
    if (const double seconds = slow * all.wall_time_s; options.max_time_s > 0.0 && seconds > options.max_time_s)
        plan.max_time = fmt::format("no point begins after {} (--max-time): about {:.0f} % of the work", human_time(options.max_time_s),
                                    100.0 * options.max_time_s / seconds);
    return plan;
}

std::vector<PointStatus> status_of(const Study& study) {
    const std::vector<StudyRow> rows = read_rows(study);
    std::vector<PointStatus> list;
    for (const Point& point : study.points) list.push_back(status_of(study, point, rows));
    return list;
}

}  // namespace porepack::study
