#include "bindings/host.hpp"

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include "core/context.hpp"
#include "core/machine.hpp"

namespace porepack::python {
namespace {

namespace py = pybind11;

struct LogLine {
    bool warning;
    std::string text;
};
struct ProgressNews {
    std::string label;
    double fraction, seconds;
    std::string detail;
};

// What the work says, until the caller's thread passes it on.
class Mailbox {
public:
    void add(LogLine line) {
        const std::lock_guard lock(mutex_);
        lines_.push_back(std::move(line));
    }
    // Only the last of several is worth showing; one that ends a step is not replaced.
    void add(ProgressNews news) {
        const std::lock_guard lock(mutex_);
        if (!news_.empty() && news_.back().label == news.label && news_.back().fraction < 1.0) news_.pop_back();
        news_.push_back(std::move(news));
    }
    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }
    // True when the work has ended.
    bool wait(std::chrono::milliseconds time) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, time, [this] { return closed_; });
    }
    void pass_on(const py::module_& host) {
        std::deque<LogLine> lines;
        std::deque<ProgressNews> news;
        {
            const std::lock_guard lock(mutex_);
            lines.swap(lines_);
            news.swap(news_);
        }
        for (const LogLine& line : lines) host.attr("on_log")(line.warning, line.text);
        for (const ProgressNews& one : news) host.attr("on_progress")(one.label, one.fraction, one.seconds, one.detail);
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<LogLine> lines_;
    std::deque<ProgressNews> news_;
    bool closed_ = false;
};

}  // namespace

void run_in_thread(const std::function<void()>& work) {
    const py::module_ host = py::module_::import("porepack._host");
    Mailbox mailbox;
    std::atomic<bool> stop = false;
    const core::Context context{.log =
                                    [&](core::LogLevel level, std::string_view line) {
                                        mailbox.add(LogLine{level == core::LogLevel::warning, std::string(line)});
                                    },
                                .progress =
                                    [&](std::string_view label, double fraction, double seconds, std::string_view detail) {
                                        mailbox.add(ProgressNews{std::string(label), fraction, seconds, std::string(detail)});
                                    },
                                .interrupted = [&] { return stop.load(std::memory_order_relaxed); }};
    std::exception_ptr fault, raised;
    std::thread worker([&, threads = host.attr("threads").cast<int>()] {
        const core::ContextScope scope(context);
        try {
            core::set_thread_count(threads);  // of this thread's loops
            work();
        } catch (...) {
            fault = std::current_exception();
        }
        mailbox.close();
    });
    for (bool done = false; !done;) {
        {
            const py::gil_scoped_release others;
            done = mailbox.wait(std::chrono::milliseconds(50));
        }
        if (raised) continue;
        try {
            mailbox.pass_on(host);
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        } catch (...) {
            raised = std::current_exception();
            stop = true;
        }
    }
    worker.join();
    if (raised) std::rethrow_exception(raised);
    if (fault) std::rethrow_exception(fault);
}

}  // namespace porepack::python
