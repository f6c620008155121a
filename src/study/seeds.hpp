// Several packings of one case, from consecutive seeds.
#pragma once

#include "stages/stages.hpp"

namespace porepack {

/// k of the case's packing and of those with the next seeds, each in its own folder of results (seed_<n>), so that an interrupted study
/// resumes; seeds.csv, mean, standard deviation and standard error.
[[nodiscard]] Stage make_seeds_stage(const Case& c);

}  // namespace porepack
