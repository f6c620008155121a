// Work that porepack does as several ranks of MPI, which mpirun starts: on this machine, or on those of the batch job in which it runs.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::pipeline {

/// Runs the program porepack with these arguments as so many ranks, until all have ended; what they print appears as if this process
/// printed it. `folder`: one that all ranks see. Without OMP_NUM_THREADS, the ranks on a machine share its cores; where this process is
/// limited to fewer threads, they share these. Interrupted, it asks the ranks to stop (SIGUSR1), so that they can write a checkpoint.
/// Throws the error of the first rank that failed; EngineError where mpirun is missing; MachineError where a rank ended without a word.
void run_ranks(long ranks, const std::vector<std::string>& arguments, const core::Path& folder);

/// Of a rank: tells run_ranks() why it ends. False if it was not started by it, or cannot write it.
bool tell_starter(const std::string& message, int exit_code);

}  // namespace porepack::pipeline
