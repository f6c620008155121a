// A case as a pipeline: what a program runs.
#pragma once

#include "pipeline/pipeline.hpp"
#include "stages/case.hpp"

namespace porepack::study {

/// All stages and studies that the case asks for; results go to case.results(). Run it with run_pipeline(), which resumes what was
/// interrupted. Throws UserError for settings that no stage can be made from.
[[nodiscard]] pipeline::Pipeline case_pipeline(const stages::Case& c);

}  // namespace porepack::study
