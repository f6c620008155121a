// Several packings of one case, from consecutive seeds: a fixed number, or until the mean permeability is sure.
#pragma once

#include "stages/stages.hpp"

namespace porepack::study {

/// [packings]: porosity, tortuosities and k of the case's packing and of those with the next seeds, each in its own folder of results
/// (seed_<n>), several at once, so that an interrupted study resumes; seeds.csv, and for each quantity the mean, the standard deviation,
/// and the intervals of the mean and of the next packing. With `until_sure`, packings count in the order of their seeds, so that the
/// result does not depend on the number of threads, and fast packings are not preferred.
[[nodiscard]] pipeline::Stage make_seeds_stage(const stages::Case& c);

}  // namespace porepack::study
