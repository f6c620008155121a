#include "study/scheduler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <sstream>
#include <thread>

#include "core/context.hpp"
#include "core/error.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace {

// The last error of a log, without its advice; else its last line.
std::string message_of(const Path& log) {
    std::istringstream lines(read_text(log));
    std::string last, error;
    for (std::string line; std::getline(lines, line);) {
        if (!line.empty()) last = line;
        if (line.starts_with("error: ")) error = line.substr(7);
    }
    return error.empty() ? last : error;
}

class Workers {
public:
    Workers(int at_once, const std::function<std::optional<Job>()>& next, const std::function<void(const JobEnd&)>& ended)
        : program_(require_porepack()), threads_(std::max(1, thread_count() / at_once)), next_(next), ended_(ended) {
        std::vector<std::thread> threads;
        threads.reserve(static_cast<std::size_t>(at_once));
        for (int i = 0; i < at_once; ++i)
            threads.emplace_back([this, &run = context()] {
                const ContextScope here(run);
                work();
            });
        for (std::thread& thread : threads) thread.join();
        if (fault_) std::rethrow_exception(fault_);
    }

private:
    static std::string require_porepack() {
        const std::optional<Path> program = porepack_program();
        if (!program)
            throw EngineError("the program porepack was not found, which runs several cases at once",
                              {.fix = "put it on PATH, or beside this program"});
        return program->string();
    }

    // A job ends while another waits: it may be wanted now. With no job running, none will be.
    void work() {
        std::unique_lock lock(mutex_);
        while (!fault_) {
            std::optional<Job> job;
            guarded([&] { job = next_(); });
            if (fault_ || (!job && running_ == 0)) break;
            if (!job) {
                changed_.wait(lock);
                continue;
            }
            ++running_;
            lock.unlock();
            JobEnd end{.name = job->name};
            std::exception_ptr fault;
            try {
                end.error = run(*job);
            } catch (...) {
                fault = std::current_exception();
            }
            lock.lock();
            --running_;
            if (fault)
                guarded([&] { std::rethrow_exception(fault); });
            else
                guarded([&] { ended_(end); });
            changed_.notify_all();
        }
        changed_.notify_all();
    }

    void guarded(const std::function<void()>& call) {
        try {
            call();
        } catch (...) {
            if (!fault_) fault_ = std::current_exception();
        }
        stopped_ = stopped_ || fault_;
    }

    std::string run(const Job& job) {
        Program program{.command = {program_}, .log = job.log};
        program.command.insert(program.command.end(), job.arguments.begin(), job.arguments.end());
        program.command.insert(program.command.end(), {"--threads", std::to_string(threads_)});
        program.while_running = [this] {
            if (stopped_) throw MachineError("stopped, because another run failed");
        };
        const ProgramEnd end = run_program(program);
        if (end.exit_code == 0) return {};
        const std::string message = message_of(job.log);
        return message.empty() ? fmt::format("exit code {}, and no message", end.exit_code) : message;
    }

    const std::string program_;
    const int threads_;
    const std::function<std::optional<Job>()>& next_;
    const std::function<void(const JobEnd&)>& ended_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::exception_ptr fault_;
    std::atomic<bool> stopped_ = false;
    int running_ = 0;
};

}  // namespace

int jobs_at_once(double memory_bytes_of_each) {
    if (memory_bytes_of_each <= 0.0) return 1;
    return std::clamp(static_cast<int>(0.8 * available_memory_bytes() / memory_bytes_of_each), 1, thread_count());
}

void run_jobs(int at_once, const std::function<std::optional<Job>()>& next, const std::function<void(const JobEnd&)>& ended) {
    const Workers workers(at_once, next, ended);
}

}  // namespace porepack::study
