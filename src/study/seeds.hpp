// Several packings of one case, from consecutive seeds.
#pragma once

#include "stages/stages.hpp"

namespace porepack::study {

/// k of the case's packing and of those with the next seeds, each in its own folder of results (seed_<n>), so that an interrupted study
/// resumes; seeds.csv, mean, standard deviation and standard error.
[[nodiscard]] pipeline::Stage make_seeds_stage(const stages::Case& c);

}  // namespace porepack::study
