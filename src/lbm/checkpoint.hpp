// The state of a sequence of grids on disk: a line of JSON, then the populations in their memory layout.
#pragma once

#include <span>

#include "core/error.hpp"
#include "core/files.hpp"
#include "lbm/permeability.hpp"

namespace porepack::lbm {

/// A run resumes only from its own checkpoint.
struct CheckpointOfAnotherRun : core::UserError {
    explicit CheckpointOfAnotherRun(const core::Path& path)
        : core::UserError("the checkpoint is of another run: its settings or its geometry differ",
                          {.where = path.string(), .fix = "remove the file to start again"}),
          file(path) {}
    core::Path file;
};

/// Contents of a checkpoint besides the populations.
struct SavedRun {
    std::string identity;          ///< of the grid and all settings: a run resumes only from its own checkpoint
    long attempts = 0;             ///< grids started before this one, including omitted ones
    double relaxation_time = 0.0;  ///< of the grid that was interrupted
    std::vector<LbmGridResult> grids;
    StokesRun run;  ///< steps, seconds and history of the grid that was interrupted
};

void write_checkpoint(const core::Path& path, const SavedRun& saved, std::span<const std::byte> populations);
/// Throws UserError when the file is not a checkpoint.
[[nodiscard]] SavedRun read_checkpoint(const core::Path& path);
/// Fills `populations`. Throws UserError when the file has the wrong size or contains numbers that are not finite.
void read_checkpoint_populations(const core::Path& path, std::span<std::byte> populations, Precision precision);

}  // namespace porepack::lbm
