// The state of a sequence of grids on disk: a line of JSON, then the 19 populations of each node, in the order of the cells of the whole
// grid. What several slabs have written, one process or another number of slabs can read.
#pragma once

#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "lbm/flow.hpp"
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

/// Of configuration, section, nodes and wall distances, the same for any number of slabs, all of which call it. It only has to distinguish
/// runs of this program.
[[nodiscard]] std::string identity_of(const pore_space::PoreSpace& space, LbmConfig config, const Domain& domain);

/// All slabs of the domain call it at the same step, and each writes its nodes; `saved` is that of the lowest. MachineError when the disk
/// is full or a slab does not see the file's folder; the checkpoint before it then stays.
void write_checkpoint(const core::Path& path, const SavedRun& saved, const Flow& flow, const Domain& domain);
/// Throws UserError when the file is not a checkpoint.
[[nodiscard]] SavedRun read_checkpoint(const core::Path& path);
/// Fills the populations of the slab. Throws UserError when the file has the wrong size or contains numbers that are not finite.
void read_checkpoint_populations(const core::Path& path, Flow& flow, const Domain& domain);

}  // namespace porepack::lbm
