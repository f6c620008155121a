// A folder with an OpenFOAM case made from openfoam_cases/: written, run by its Allrun, read. Only for the sources of this room.
#pragma once

#include <string>
#include <vector>

#include "core/process.hpp"
#include "openfoam/foam.hpp"

namespace porepack::openfoam {

struct FoamBlock {
    shapes::Vec3 low, high;
    std::array<int, 3> cells;
};
/// A cylinder's background block is wider than the cylinder by one cell.
[[nodiscard]] FoamBlock background_block(const packing::Container& container, const packing::Section& section, double cell_size_m);

/// The lines of caseParameters that all cases have: block, refinement, point in the pores, relaxation, processes.
[[nodiscard]] std::string common_parameters(const FoamScene& scene, const FoamConfig& config, double cell_size_m, long processes);
/// Radius of the wall; a box's sides are those of the background block: its wall is a cylinder wider than the block.
[[nodiscard]] double wall_radius_m(const FoamScene& scene);

/// Copies the case `source` to `folder`, with these parameters and the scene's surface. What is the same keeps its time, for the case's
/// Allrun starts over when an input is newer than its first step.
void prepare_foam_case(const FoamScene& scene, const std::string& parameters, const core::Path& source, const core::Path& folder);
/// Runs ./Allrun; `label` and what `state` tells go to the progress line. Fills in what the run cost.
core::ProgramEnd run_foam_case(const core::Path& folder, const char* label, const std::function<std::pair<double, std::string>()>& state,
                         FoamMeshResult& result);

/// The number behind `text` in the last line of a log that has it.
[[nodiscard]] std::optional<double> last_number(const core::Path& log, const std::string& text);
/// The series of numbers that a function object wrote: one row an iteration, `column` behind the time. A run that was stopped and went on
/// has a folder for each start; what a later one computed again counts.
[[nodiscard]] std::vector<double> read_series(const core::Path& object, const char* file, int column);
[[noreturn]] void reject_foam(const std::string& what, const core::Path& log, const std::string& fix = {});
/// Reads what checkMesh said. Throws EngineError where the mesh does not fill the pores.
void judge_foam_mesh(const FoamScene& scene, const FoamConfig& config, const core::Path& folder, FoamMeshResult& result);

}  // namespace porepack::openfoam
