// Runs independent cases, several at once as far as cores and memory suffice.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::study {

/// One run of this program in its own process, so that a case that fails or needs too much memory leaves the others alone.
struct Job {
    std::string name;                    ///< for messages
    std::vector<std::string> arguments;  ///< of porepack
    core::Path log;                      ///< what it prints
};

struct JobEnd {
    std::string name;
    std::string error = {};  ///< empty if it succeeded, else the error in its log
};

/// Number of jobs at once: one per thread of this program, as many as the free memory holds, at least one; one if
/// the memory is not known. Each job gets an equal share
/// of the threads.
[[nodiscard]] int jobs_at_once(double memory_bytes_of_each);

/// `next` gives the next job, or nothing when none is wanted now; it is called again after each end. Returns when no job runs and `next`
/// gives none. `ended` and `next` are called by one thread at a time. What they throw stops all jobs and is passed on; so is an
/// interruption. Throws EngineError when the program porepack is not found.
void run_jobs(int at_once, const std::function<std::optional<Job>()>& next, const std::function<void(const JobEnd&)>& ended);

}  // namespace porepack::study
