// A study for a workflow engine.
#pragma once

#include "core/files.hpp"
#include "study/study.hpp"

namespace porepack::study {

/// Writes a Snakefile for Snakemake 7: one rule for the points, one for the figures. Returns its path.
core::Path write_snakefile(const Study& study);

}  // namespace porepack::study
