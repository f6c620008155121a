// The cases of a study: one case with other values of some keys, each with its own folder of results.
#pragma once

#include <string>
#include <vector>

#include "stages/case.hpp"
#include "study/scheduler.hpp"

namespace porepack::study {

/// The same case with the seed `seed`, in results/seed_<n>.
[[nodiscard]] stages::Case case_of_seed(const stages::Case& c, long seed);

/// Runs the case up to the stage `last` (`porepack run CASE --up-to LAST --set ...`); its messages go to log.porepack in its results.
[[nodiscard]] Job job_of(const stages::Case& c, const std::string& last, const std::string& name);
/// Memory that it needs, in bytes.
[[nodiscard]] double expected_memory_bytes(const stages::Case& c, const std::string& last);

}  // namespace porepack::study
