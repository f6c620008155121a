// A folder with an OpenFOAM case made from openfoam_cases/: written, run by its Allrun, read. Only for the sources of this folder.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/process.hpp"
#include "openfoam/foam.hpp"

namespace porepack::openfoam {

struct FoamBlock {
    shapes::Vec3 low, high;
    std::array<int, 3> cells;
};
/// A cylinder's background block is wider than the cylinder by one cell.
[[nodiscard]] FoamBlock background_block(const vessels::Container& container, const packing::Section& section, double cell_size_m);

/// The lines of caseParameters that all cases share: block, refinement, point in the pores, relaxation, processes.
[[nodiscard]] std::string common_parameters(const FoamScene& scene, const FoamConfig& config, double cell_size_m, long processes);
/// The surfaces of the round walls. A box's sides are those of the background block: its wall is a cylinder wider than the block.
[[nodiscard]] std::string wall_parameters(const FoamScene& scene);

/// Copies the case `source` to `folder`, with these parameters and the scene's surface. Unchanged files keep their time, because the case's
/// Allrun starts again when an input is newer than its first step.
void prepare_foam_case(const FoamScene& scene, const std::string& parameters, const core::Path& source, const core::Path& folder);
struct FoamState {
    std::optional<double> seconds_left;
    std::string text;
};
/// Phase of snappyHexMesh, from its log.
[[nodiscard]] std::string meshing_phase(const core::Path& folder);
/// Iteration of simpleFoam, and the seconds left if the residual of p goes on falling to `residual` at its present rate.
[[nodiscard]] FoamState solving_state(const core::Path& folder, double residual);
/// Runs ./Allrun; `label` and the text from `state` appear in the progress line. Fills in the cost of the run.
core::ProgramEnd run_foam_case(const core::Path& folder, const char* label, const std::function<FoamState()>& state,
                               FoamMeshResult& result);

/// The number after `text` in the last line of a log that contains it.
[[nodiscard]] std::optional<double> last_number(const core::Path& log, const std::string& text);
/// The series of numbers that a function object wrote: one row per iteration, `column` after the time. A run that was stopped and resumed
/// has a folder for each start; values of a later start replace earlier ones.
[[nodiscard]] std::vector<double> read_series(const core::Path& object, const char* file, int column);
[[noreturn]] void reject_foam(const std::string& what, const core::Path& log, const std::string& fix = {});
/// Reads the output of checkMesh. Throws EngineError if the mesh does not fill the pores.
void judge_foam_mesh(const FoamScene& scene, const FoamConfig& config, const core::Path& folder, FoamMeshResult& result);

}  // namespace porepack::openfoam
