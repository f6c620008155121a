// Tables and figures of a study of causes.
#pragma once

#include "analysis/outcome.hpp"
#include "falling_head/causes.hpp"
#include "falling_head/config.hpp"

namespace porepack::analysis {

[[nodiscard]] const char* evidence_of(const falling_head::UncertainCause& cause);
/// causes.csv, joint.csv, effects.csv, and their figures.
[[nodiscard]] Files files_of_causes(const falling_head::CauseStudy& study, const falling_head::SampleTruth& sample,
                                    const falling_head::FallingHeadConfig& config);

}  // namespace porepack::analysis
