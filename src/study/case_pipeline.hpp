// A case as a pipeline of stages.
#pragma once

#include "pipeline/pipeline.hpp"
#include "stages/case.hpp"

namespace porepack::study {

/// All stages and studies that the case enables; results go to case.results(). Run it with run_pipeline(), which resumes what was
/// interrupted. Throws UserError for settings from which no stage can be made.
[[nodiscard]] pipeline::Pipeline case_pipeline(const stages::Case& c);

}  // namespace porepack::study
